"""Furniture under construction: parts that number themselves, and the joints between them."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal

from numpy.typing import ArrayLike

from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Furniture, Joint, Parts
from openrooms_usd.geometry.mesh import Mesh

# Doors open this far, degrees.
SWING: Final = 110.0

Side = Literal["left", "right", "bottom", "top"]
# Axes about which a leaf opens towards the front when it hangs on this side.
AXES: Final[dict[Side, tuple[float, float, float]]] = {
    "left": (0.0, 0.0, -1.0),
    "right": (0.0, 0.0, 1.0),
    "bottom": (1.0, 0.0, 0.0),
    "top": (-1.0, 0.0, 0.0),
}


@dataclass
class Assembly:
    """Parts so far, and how some of them move.

    Attributes:
        parts: Meshes by their numbered names.
        joints: How groups of them move.
    """

    parts: Parts = field(default_factory=dict)
    joints: list[Joint] = field(default_factory=list)
    _parts: Counter[str] = field(default_factory=Counter)
    _joints: Counter[str] = field(default_factory=Counter)

    def add(self, part: str, *meshes: Mesh) -> tuple[str, ...]:
        """Add instances of a part.

        Returns:
            Their names.
        """
        names = tuple(_numbered(self._parts, part) for _ in meshes)
        self.parts.update(zip(names, meshes, strict=True))
        return names

    def board(
        self, part: str, low: ArrayLike, high: ArrayLike, edge: float = 0.002
    ) -> tuple[str, ...]:
        """Add a board between two opposite corners, and give its name."""
        return self.add(part, board(low, high, edge))

    def hinge(
        self,
        name: str,
        meshes: Iterable[str],
        origin: Sequence[float],
        side: Side,
        upper: float = SWING,
    ) -> None:
        """Hang parts on one side, so that they open to the front by ``upper`` degrees."""
        x, y, z = (float(value) for value in origin)
        self.joints.append(
            Joint(
                _numbered(self._joints, name),
                "hinge",
                tuple(meshes),
                (x, y, z),
                AXES[side],
                (0.0, upper),
            )
        )

    def rail(
        self,
        name: str,
        meshes: Iterable[str],
        travel: float,
        axis: tuple[float, float, float] = (0.0, -1.0, 0.0),
    ) -> None:
        """Let parts slide by ``travel`` metres along an axis, to the front by default."""
        # A rail has no point of its own: the middle of what slides reads best as its pivot.
        moved = tuple(meshes)
        low, high = self.parts[moved[0]].extent
        x, y, z = (0.5 * (low + high)).tolist()
        self.joints.append(
            Joint(_numbered(self._joints, name), "rail", moved, (x, y, z), axis, (0.0, travel))
        )

    def turn(
        self,
        name: str,
        meshes: Iterable[str],
        origin: Sequence[float],
        axis: tuple[float, float, float],
        limits: tuple[float, float],
    ) -> None:
        """Let parts turn about any axis: knobs, levers and taps; limits in degrees."""
        x, y, z = (float(value) for value in origin)
        self.joints.append(
            Joint(_numbered(self._joints, name), "hinge", tuple(meshes), (x, y, z), axis, limits)
        )

    def ride(self, *names: str) -> None:
        """Let parts move with the joint that was made last."""
        last = self.joints[-1]
        self.joints[-1] = replace(last, meshes=last.meshes + names)

    def furniture(self) -> Furniture:
        """What has been built."""
        return Furniture(self.parts, tuple(self.joints))


def _numbered(made: Counter[str], name: str) -> str:
    made[name] += 1
    return f"{name}_{made[name] - 1}"
