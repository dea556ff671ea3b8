"""Mass, centre and inertia of rigid pieces, and what can be done with them."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise, permutations, product
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError

# Moments that differ by less than this share of the largest are one.
_SAME_MOMENT_SHARE: Final = 1e-7
# A choice between axes must not hang on the last bits.
_TIE_DECIMALS: Final = 6


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass, centre of mass and inertia of one rigid piece.

    Attributes:
        mass: Kilograms.
        centre: (3,) centre of mass in the piece's frame, metres.
        inertia: (3, 3) tensor about the centre, along the axes of the piece's frame, kg m2.
        notes: What was mended or approximated in the surface it is from, one sentence each.
    """

    mass: float
    centre: Array
    inertia: Array
    notes: tuple[str, ...] = ()

    def second_moments(self) -> Array:
        """(3, 3) the integral of x x^T over the mass, about the centre; J = tr(C) 1 - C."""
        return np.asarray(0.5 * np.trace(self.inertia) * np.eye(3) - self.inertia)

    def about(self, point: ArrayLike) -> Array:
        """(3, 3) inertia about another point of the frame, by the theorem of parallel axes."""
        offset = self.centre - np.asarray(point, dtype=np.float64)
        return self.inertia + self.mass * _inertia_of(np.outer(offset, offset))

    def transformed(self, matrix: ArrayLike) -> "MassProperties":
        """The piece in another frame.

        Args:
            matrix: (4, 4) for column vectors: a rotation or a mirror, and a translation.

        Raises:
            InputError: It scales or shears; scale the geometry, for walls keep their thickness.
        """
        M = np.asarray(matrix, dtype=np.float64)
        R = M[:3, :3]
        if not np.allclose(R.T @ R, np.eye(3), atol=1e-6):
            raise InputError(
                "the mass of a piece cannot be moved by a matrix that scales or shears",
                remedy="put the scale into the piece's points and weigh those",
            )
        return replace(self, centre=R @ self.centre + M[:3, 3], inertia=R @ self.inertia @ R.T)

    def scaled(self, factors: ArrayLike) -> "MassProperties":
        """The piece of the same density, stretched along its axes about the frame's origin.

        Right for solid pieces. The walls of a shell would be stretched too: scale its points.

        Args:
            factors: Three factors, or one for all axes; negative ones mirror.
        """
        S = np.broadcast_to(np.asarray(factors, dtype=np.float64), 3)
        growth = abs(float(np.prod(S)))
        moments = growth * self.second_moments() * np.outer(S, S)
        return replace(
            self, mass=self.mass * growth, centre=self.centre * S, inertia=_inertia_of(moments)
        )

    def weighing(self, kilograms: float) -> "MassProperties":
        """The same piece with the density that gives it a known mass.

        Raises:
            InputError: The mass is not positive.
        """
        if not (np.isfinite(kilograms) and kilograms > 0):
            raise InputError(
                f"mass must be positive, got {kilograms:g} kg", remedy="give kilograms above zero"
            )
        share = kilograms / self.mass
        return replace(self, mass=float(kilograms), inertia=self.inertia * share)

    def principal(self) -> tuple[Array, Array]:
        """Principal moments and axes.

        Of all the orders and signs of the axes the one nearest to the piece's own axes is taken;
        of the axes of repeated moments, those that its own axes cast on their plane. So equal
        bodies have equal axes, and a tensor that is diagonal keeps its own.

        Returns:
            (3,) moments, and the (3, 3) rotation whose columns are their axes, right-handed:
            ``inertia = R @ diag(moments) @ R.T``.
        """
        moments, axes = np.linalg.eigh(0.5 * (self.inertia + self.inertia.T))
        near = _SAME_MOMENT_SHARE * abs(moments).max()
        starts = [0, *(np.flatnonzero(np.diff(moments) > near) + 1).tolist(), 3]
        basis = np.concatenate([_settled(axes[:, a:b]) for a, b in pairwise(starts)], axis=1)
        turned = [
            basis[:, order] * signs
            for order in permutations(range(3))
            for signs in product((1.0, -1.0), repeat=3)
            if np.linalg.det(basis[:, order] * signs) > 0
        ]
        rotation = turned[int(np.argmax([round(np.trace(R), _TIE_DECIMALS) for R in turned]))] + 0.0
        return np.einsum("ki,kl,li->i", rotation, self.inertia, rotation), rotation

    def checked(self, place: object = None) -> "MassProperties":
        """The same, where a rigid body can have it.

        Args:
            place: Whose mass it is, for the message.

        Raises:
            InputError: The mass is not positive, a number is not finite, or the moments are not
                those of any distribution of mass: one is not positive, or more than the sum of the
                other two.
        """
        values = [self.mass, *self.centre, *self.inertia.flat]
        moments = np.linalg.eigvalsh(self.inertia) if np.isfinite(values).all() else np.full(3, -1)
        rules = {
            "its mass, centre or inertia is not a finite number": np.isfinite(values).all(),
            f"its mass of {self.mass:g} kg is not positive": self.mass > 0,
            "its inertia is not symmetric": np.allclose(
                self.inertia, self.inertia.T, rtol=0, atol=1e-9 * abs(moments[2])
            ),
            "its moments of inertia are not positive": moments[0] > 0,
            "one of its moments of inertia is more than the sum of the other two": (
                moments[2] <= (moments[0] + moments[1]) * (1 + 1e-9)
            ),
        }
        if broken := next((rule for rule, kept in rules.items() if not kept), None):
            raise InputError(
                f"this cannot be a rigid body: {broken}",
                place=place,
                remedy="check its mesh, its scale and the density or mass that it is given",
            )
        return self


def combined(parts: Iterable[MassProperties]) -> MassProperties:
    """One rigid piece of several, all in one frame; where they overlap both count.

    Raises:
        InputError: There are none.
    """
    pieces = tuple(parts)
    mass = sum(piece.mass for piece in pieces)
    if not pieces or not mass:
        raise InputError(
            "a body without any mass", remedy="give it a part with a surface, or fix it in place"
        )
    centre = sum((piece.mass * piece.centre for piece in pieces), np.zeros(3)) / mass
    inertia = sum((piece.about(centre) for piece in pieces), np.zeros((3, 3)))
    notes = dict.fromkeys(note for piece in pieces for note in piece.notes)
    return MassProperties(float(mass), centre, inertia, tuple(notes))


def from_moments(
    mass: float, first: Array, second: Array, notes: tuple[str, ...] = ()
) -> MassProperties:
    """Properties from the integrals of 1, x (3,) and x x^T (3, 3) over the mass."""
    centre = first / mass
    return MassProperties(
        float(mass), centre, _inertia_of(second - mass * np.outer(centre, centre)), notes
    )


def _inertia_of(second: Array) -> Array:
    """Inertia of second moments."""
    return np.asarray(np.trace(second) * np.eye(3) - second)


def _settled(axes: Array) -> Array:
    """(3, k) a basis of the space of (3, k) orthonormal axes that hangs on that space alone."""
    left, chosen = axes @ axes.T, []
    for _ in range(axes.shape[1]):
        lengths = np.linalg.norm(left, axis=0)
        column = left[:, int(np.argmax(np.round(lengths, _TIE_DECIMALS)))]
        chosen.append(column / np.linalg.norm(column))
        left = left - np.outer(chosen[-1], chosen[-1] @ left)
    return np.stack(chosen, axis=1)
