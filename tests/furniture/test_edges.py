"""What joiners make has no sharp edges: light catches a bevel of a millimetre or more."""

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES, make, part_of
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors
from openrooms_usd.geometry.solids import box, rounded_box

JOINED = {"tabletop", "leg", "door", "drawer_front", "shelf", "rail", "headboard"}
PIECES = tuple(
    """
    table chair coffee_table desk cabinet dresser bookshelf wardrobe side_table bench bed stool
    armchair
    """.split()
)


def sharp(mesh: Mesh) -> tuple[float, float]:
    """Metres of convex edges at which two flat sides meet at 60 degrees or more, and of all."""
    vectors = face_vectors(mesh)
    normals = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-15)
    ends = np.cumsum(mesh.counts)
    following = np.arange(len(mesh.indices)) + 1
    following[ends - 1] = ends - mesh.counts
    face = np.repeat(np.arange(len(mesh.counts)), mesh.counts)
    a, b = mesh.indices, mesh.indices[following]
    order = np.lexsort((np.maximum(a, b), np.minimum(a, b)))
    pair = np.sort(np.stack([a, b], axis=1), axis=1)[order]
    same = np.flatnonzero((pair[1:] == pair[:-1]).all(axis=1))
    first, second = order[same], order[same + 1]
    length = np.linalg.norm(mesh.points[a[first]] - mesh.points[b[first]], axis=1)
    cos = np.einsum("ij,ij->i", normals[face[first]], normals[face[second]])
    middle = np.add.reduceat(mesh.points[mesh.indices], ends - mesh.counts) / mesh.counts[:, None]
    outward = np.einsum(
        "ij,ij->i", middle[face[second]] - middle[face[first]], normals[face[first]]
    )
    convex = outward < -1e-9
    return float(length[convex & (cos < 0.5)].sum()), float(length[convex & (cos < 0.98)].sum())


def test_edges_are_told_apart() -> None:
    cube = sharp(box((1.0, 1.0, 1.0)))
    assert cube[0] == pytest.approx(12.0) == cube[1]
    assert sharp(rounded_box((1.0, 1.0, 1.0), 0.003))[0] == 0.0


@pytest.mark.parametrize("category", PIECES)
def test_boards_and_legs_are_bevelled(category: str) -> None:
    spec = CATEGORIES[category]
    for style in spec.styles:
        made = make(category, spec.styles[style].size or spec.size, style, np.random.default_rng(0))
        for name, mesh in made.parts.items():
            if part_of(name) in JOINED:
                edges, all_of_them = sharp(mesh)
                assert edges <= 0.1 * all_of_them, (style, name, edges)
