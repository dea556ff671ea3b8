"""Numbers for objects, parts, materials and classes, and what they mean."""

from dataclasses import dataclass
from typing import Final

from pxr import Usd, UsdShade

from openrooms_usd import names
from openrooms_usd.channels import CLASS_CHANNELS
from openrooms_usd.rendering.scene.arrays import Piece
from openrooms_usd.rendering.scene.legend import Legend
from openrooms_usd.usd.semantics import TAXONOMIES, read_label, read_number


class Labels:
    """Numbers whatever is seen, from 1, in the order in which it is met."""

    def __init__(self) -> None:
        self.pieces: list[Piece] = []
        self._rows: dict[Piece, int] = {}
        self._instances: dict[str, int] = {}
        self._parts: dict[str, int] = {}
        self._materials: dict[str, int] = {}
        self._categories: dict[int, str] = {}
        self._objects: dict[str, tuple[int, tuple[int, ...]]] = {}
        self._owners: dict[str, _Owner] = {}

    def row(self, path: str, prim: Usd.Prim, material: str | None) -> int:
        """The row in `pieces` of a surface.

        Args:
            path: Where it stands.
            prim: Its prim; below a point instancer that is the prototype's.
            material: Path of its material, if it has one.
        """
        instance, numbers = self._object(path, prim)
        piece = Piece(
            instance,
            _number(self._parts, path),
            0 if material is None else _number(self._materials, material),
            *numbers,
        )
        if piece not in self._rows:
            self._rows[piece] = len(self.pieces)
            self.pieces.append(piece)
        return self._rows[piece]

    @property
    def legend(self) -> Legend:
        """What the numbers mean."""
        return Legend(
            **{channel: TAXONOMIES[name] for name, channel in CLASS_CHANNELS.items()},
            instance=_names(self._instances),
            part=_names(self._parts),
            material=_names(self._materials),
            category=dict(self._categories),
        )

    def _object(self, path: str, prim: Usd.Prim) -> tuple[int, tuple[int, ...]]:
        """Instance number and classes of the object that a surface is part of."""
        at = str(prim.GetPath())
        if at not in self._owners:
            self._owners[at] = _Owner.of(prim)
        owner = self._owners[at]
        stands = path if owner.levels == 0 else path.rsplit("/", owner.levels)[0]
        if stands not in self._objects:
            instance = _number(self._instances, stands)
            if owner.category:
                self._categories[instance] = owner.category
            self._objects[stands] = instance, owner.classes
        return self._objects[stands]


_LABELS: Final = frozenset(
    f"SemanticsLabelsAPI:{kind}" for kind in (names.CATEGORY, *CLASS_CHANNELS)
)


@dataclass(frozen=True)
class _Owner:
    """The object that a surface is part of: levels above it, its category, numbers of classes."""

    levels: int
    category: str | None
    classes: tuple[int, ...]

    @staticmethod
    def of(prim: Usd.Prim) -> "_Owner":
        owner, levels = _owner(prim)
        if not _is_labelled(owner):
            # Then nothing above it is labelled either.
            return _Owner(levels, None, (0,) * len(CLASS_CHANNELS))
        classes = tuple(read_number(owner, name) for name in CLASS_CHANNELS)
        return _Owner(levels, read_label(owner, names.CATEGORY), classes)


def _owner(prim: Usd.Prim) -> tuple[Usd.Prim, int]:
    """The prim of the object that a surface is part of, and how many levels above it stands.

    That is the nearest labelled prim, else the nearest component, else the surface itself.
    """
    chain = [prim]
    while not chain[-1].GetParent().IsPseudoRoot():
        chain.append(chain[-1].GetParent())
    tests = (_is_labelled, Usd.Prim.IsComponent)
    for test in tests:
        for levels, candidate in enumerate(chain):
            if test(candidate):
                return candidate, levels
    return prim, 0


def _is_labelled(prim: Usd.Prim) -> bool:
    return not _LABELS.isdisjoint(prim.GetAppliedSchemas())


def material_path(material: UsdShade.Material | None) -> str | None:
    """The path of a material, or None."""
    return None if material is None else str(material.GetPath())


def _number(numbers: dict[str, int], name: str) -> int:
    return numbers.setdefault(name, len(numbers) + 1)


def _names(numbers: dict[str, int]) -> dict[int, str]:
    return {number: name for name, number in numbers.items()}
