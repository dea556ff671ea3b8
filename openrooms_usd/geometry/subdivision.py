"""Subdivision surfaces: polygons refined by Catmull and Clark, by Loop, or bilinearly; normals.

Weights are sparse matrices from points to points, so that whatever is carried by points goes the
same way. Edges and points are sharp by a number, as in DeRose, Kass and Truong ("Subdivision
Surfaces in Character Animation", 1998) and OpenSubdiv. Each refinement subtracts one, a rest below
one is blended, and boundaries stay sharp.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, eye_array, vstack
from scipy.sparse.csgraph import connected_components

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.cages import Cage, Weights, matrix

# Of each face beside an edge, in its new point; triangles may have the other one, which leaves
# fewer dents.
_FACE_WEIGHT: Final = 0.25
_TRIANGLE_WEIGHT: Final = 0.470
# With more faces, what is sharp for a while is taken for sharp on the limit.
_MOST_SHARP_FACES: Final = 50_000


@dataclass(frozen=True, eq=False)
class Refinement:
    """What came of a cage.

    Attributes:
        cage: The finer one.
        faces: (F',) the face of the first cage that each face is a part of.
        weights: (N', N) from points of the first cage.
    """

    cage: Cage
    faces: Ints
    weights: Weights


def refine(
    cage: Cage, scheme: str, levels: int, *, linear: bool = False, smooth_triangles: bool = False
) -> Refinement:
    """Refine polygons several times.

    Faces and their corners come in an order that depends on the counts and the scheme alone, so
    that values of corners can be refined as polygons of their own.

    Args:
        cage: The polygons; for ``loop`` triangles.
        scheme: ``catmullClark``, ``loop`` or ``bilinear``.
        levels: How often; each makes a face four, a polygon as many as it has corners.
        linear: Whether new points are means of those beside them, and old ones stay.
        smooth_triangles: Whether Catmull-Clark takes triangles by the smoother rule.
    """
    linear = linear or scheme == "bilinear"
    faces, weights = np.arange(len(cage.counts)), eye_array(len(cage.corners), format="csr")
    for _ in range(levels):
        loop = scheme == "loop"
        step = _triangles(cage, linear) if loop else _quads(cage, linear, smooth_triangles)
        cage, faces, weights = step.cage, faces[step.faces], csr_array(step.weights @ weights)
    return Refinement(cage, faces, weights)


def limit(cage: Cage, scheme: str) -> Weights:
    """(N, N) where points of a cage lie on the surface of endless refinement.

    Args:
        cage: Refined at least once: quadrilaterals, for ``loop`` triangles.
        scheme: As in `refine`.
    """
    if scheme == "bilinear":
        return eye_array(len(cage.corners), format="csr")
    left = max(
        cage.sharpness[np.isfinite(cage.sharpness)].max(initial=0.0),
        cage.corners[np.isfinite(cage.corners)].max(initial=0.0),
    )
    if left > 0.0 and len(cage.counts) <= _MOST_SHARP_FACES:
        # The limit is known where nothing is sharp for a while: old points keep their number.
        fine = refine(cage, scheme, 1)
        return csr_array((limit(fine.cage, scheme) @ fine.weights)[: len(cage.corners)])
    same = eye_array(len(cage.corners), format="csr")
    valence = _rows_sum(cage.edges_of_points)
    around = 2.0 * cage.edges_of_points @ cage.middles - _scaled(valence, same)
    if scheme == "loop":
        share = 1.0 / (3.0 / (8.0 * _loop_weight(valence)) + valence)
        smooth = _scaled(1.0 - valence * share, same) + _scaled(share, around)
    else:
        across = 4.0 * cage.faces_of_points @ cage.centers - _scaled(valence, same) - 2.0 * around
        total = valence * (valence + 5.0)
        smooth = _scaled(1.0 / total, _scaled(valence**2, same) + 4.0 * around + across)
    return _by_rule(cage, csr_array(smooth), 1.0 / 3.0)


def _quads(cage: Cage, linear: bool, smooth_triangles: bool) -> Refinement:
    count = len(cage.corners)
    middles, centers = cage.middles, cage.centers
    if linear:
        points, edges = eye_array(count, format="csr"), middles
    else:
        three = smooth_triangles & (cage.counts == 3)
        face_weight = np.where(three, _TRIANGLE_WEIGHT, _FACE_WEIGHT)
        share = cage.faces_of_edges @ face_weight / _rows_sum(cage.faces_of_edges)
        smooth = _scaled(1.0 - 2.0 * share, middles) + _scaled(share, cage.faces_of_edges @ centers)
        edges = _mixed(np.clip(cage.sharpness, 0.0, 1.0), middles, smooth)
        n = np.maximum(_rows_sum(cage.edges_of_points), 1.0)
        sides = np.maximum(_rows_sum(cage.faces_of_points), 1.0)
        kept = _scaled((n - 3.0) / n, eye_array(count, format="csr"))
        rounded = _scaled(2.0 / n**2, cage.edges_of_points @ middles)
        pulled = _scaled(1.0 / (n * sides), cage.faces_of_points @ centers)
        points = _by_rule(cage, csr_array(kept + rounded + pulled), 0.25)
    # A quadrilateral for each corner: the point, the next edge, the face, the edge before.
    indices = np.stack(
        [
            cage.indices,
            count + cage.edges,
            count + len(cage.ends) + cage.faces,
            count + cage.edges[cage.before],
        ],
        axis=1,
    )
    own, nothing = np.maximum(cage.creases - 1.0, 0.0), np.zeros(len(cage.indices))
    creases = np.stack([own, nothing, nothing, own[cage.before]], axis=1)
    new = len(cage.ends) + len(cage.counts)
    corners = np.concatenate([np.maximum(cage.corners - 1.0, 0.0), np.zeros(new)])
    finer = Cage(np.full(len(indices), 4), indices.reshape(-1), creases.reshape(-1), corners)
    return Refinement(finer, cage.faces, csr_array(vstack([points, edges, centers])))


def _triangles(cage: Cage, linear: bool) -> Refinement:
    count = len(cage.corners)
    if linear:
        points, edges = eye_array(count, format="csr"), cage.middles
    else:
        shape = len(cage.ends), count
        opposite = matrix(cage.edges, cage.indices[cage.before], 1.0, shape)
        smooth = 0.75 * cage.middles + 0.125 * opposite
        edges = _mixed(np.clip(cage.sharpness, 0.0, 1.0), cage.middles, smooth)
        valence = _rows_sum(cage.edges_of_points)
        weight = _loop_weight(valence)
        kept = _scaled(1.0 - 2.0 * valence * weight, eye_array(count, format="csr"))
        rounded = kept + _scaled(2.0 * weight, cage.edges_of_points @ cage.middles)
        points = _by_rule(cage, csr_array(rounded), 0.25)
    a, b, c = cage.indices.reshape(-1, 3).T
    ab, bc, ca = (count + cage.edges).reshape(-1, 3).T
    own = np.maximum(cage.creases - 1.0, 0.0).reshape(-1, 3)
    x, y, z, o = own[:, 0], own[:, 1], own[:, 2], np.zeros(len(own))
    indices = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1)
    creases = np.stack([x, o, z, x, y, o, o, y, z, o, o, o], axis=1)
    corners = np.concatenate([np.maximum(cage.corners - 1.0, 0.0), np.zeros(len(cage.ends))])
    finer = Cage(np.full(4 * len(a), 3), indices.reshape(-1), creases.reshape(-1), corners)
    faces = np.repeat(np.arange(len(a)), 4)
    return Refinement(finer, faces, csr_array(vstack([points, edges])))


def _by_rule(cage: Cage, smooth: Weights, along: float) -> Weights:
    """Points by the sharp edges that meet there; ``along`` weighs the middles in a crease."""

    def masks(sharp: Mask, pinned: Mask) -> tuple[Ints, Weights]:
        chosen = cage.edges_of_points @ diags_array(sharp.astype(np.float64))
        number = _rows_sum(csr_array(chosen))
        rule = np.where(pinned | (number > 2), 2, np.where(number == 2, 1, 0))
        same = eye_array(len(rule), format="csr")
        crease = (1.0 - 2.0 * along) * same + along * (chosen @ cage.middles)
        rows = [
            _scaled((rule == k).astype(np.float64), one)
            for k, one in enumerate((smooth, crease, same))
        ]
        return rule, csr_array(rows[0] + rows[1] + rows[2])

    edges, points = cage.sharpness, cage.corners
    rule, now = masks(edges > 0.0, points > 0.0)
    later, then = masks(edges > 1.0, points > 1.0)
    # Where sharpness ends here, what is left of it blends the rules of now and of later.
    ending = (edges > 0.0) & (edges <= 1.0)
    left = cage.edges_of_points @ np.where(ending, edges, 0.0)
    number = cage.edges_of_points @ ending.astype(np.float64)
    own = (points > 0.0) & (points <= 1.0)
    left, number = left + np.where(own, points, 0.0), number + own
    share = np.where(rule == later, 1.0, np.minimum(left / np.maximum(number, 1.0), 1.0))
    return _mixed(share, now, then)


def _loop_weight(valence: Array) -> Array:
    """Of each neighbour of a smooth point: Loop (1987)."""
    n = np.maximum(valence, 1.0)
    return np.asarray((0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / n)) ** 2) / n, np.float64)


def _mixed(share: Array, one: Weights, other: Weights) -> Weights:
    return csr_array(_scaled(share, one) + _scaled(1.0 - share, other))


def _scaled(factors: Array, weights: Weights) -> Weights:
    return csr_array(diags_array(factors) @ weights)


def _rows_sum(weights: Weights) -> Array:
    return np.asarray(weights.sum(axis=1), np.float64).reshape(-1)


def smooth_normals(cage: Cage, points: Array) -> Array:
    """Means of the faces around each point, weighed by area.

    Args:
        cage: The polygons; edges of any sharpness are sharp.
        points: (N, 3) their points.

    Returns:
        (K, 3) unit normals at the corners.
    """
    at = points[cage.indices]
    sides = at[cage.after] - at, at[cage.before] - at
    own = np.cross(*sides)
    # Corners that share a point belong together where an edge between them is smooth.
    smooth = np.flatnonzero(cage.sharpness == 0.0)
    order = np.argsort(cage.edges, kind="stable")
    first = np.searchsorted(cage.edges[order], smooth)
    one, other = order[first], order[first + 1]
    # The two sides of an edge run against each other in a surface that has one outside.
    turned = cage.indices[one] == cage.indices[other]
    ends = np.where(turned, other, cage.after[other]), np.where(turned, cage.after[other], other)
    rows = np.concatenate([one, cage.after[one]])
    columns = np.concatenate(ends)
    count = len(cage.indices)
    joined = coo_array((np.ones(len(rows)), (rows, columns)), (count, count))
    _, group = connected_components(joined, directed=False)
    sums = np.stack([np.bincount(group, own[:, k]) for k in range(3)], axis=1)[group]
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    flat = np.divide(own, np.maximum(np.linalg.norm(own, axis=1, keepdims=True), 1e-300))
    return np.asarray(np.where(lengths > 0.0, sums / np.maximum(lengths, 1e-300), flat))
