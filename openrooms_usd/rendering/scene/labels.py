"""Numbers for objects, parts, materials and classes, and what they mean."""

from collections.abc import Callable
from dataclasses import dataclass

from pxr import Sdf, Usd, UsdShade

from openrooms_usd.channels import CLASS_CHANNELS
from openrooms_usd.rendering.scene.arrays import PixelLabels
from openrooms_usd.rendering.scene.legend import Legend
from openrooms_usd.usd.places.ancestry import Ancestry, Key, Stand
from openrooms_usd.usd.semantics import TAXONOMIES, is_labelled, read_category, read_number


class Labels:
    """Numbers what is seen, from 1, in order of appearance.

    Args:
        stage: The composed stage.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        self.pieces: list[PixelLabels] = []
        self._rows: dict[PixelLabels, int] = {}
        self._instances: dict[str, int] = {}
        self._parts: dict[str, int] = {}
        self._materials: dict[str, int] = {}
        self._categories: dict[int, str] = {}
        self._objects: dict[str, tuple[int, tuple[int, ...]]] = {}
        self._ancestry = Ancestry(stage)
        self._labelled: dict[Sdf.Path, bool] = {}
        self._owners: dict[Key, _Owner] = {}

    def row(self, path: str, material: str | None) -> int:
        """The row in `pieces` of a surface.

        Args:
            path: Where it stands.
            material: Path of its material, if it has one.
        """
        instance, numbers = self._object(path)
        piece = PixelLabels(
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

    def _object(self, path: str) -> tuple[int, tuple[int, ...]]:
        """Instance number and classes of the object that a surface is part of.

        That is the nearest labelled prim, else the nearest component, else the surface itself.
        """
        key, instance_of = self._ancestry.shared(path)
        if key not in self._owners:
            self._owners[key] = self._owner(path, instance_of)
        owner = self._owners[key]
        stands = f"{instance_of}{owner.place}" if owner.is_in_instance else owner.place
        if stands not in self._objects:
            instance = _number(self._instances, stands)
            if owner.category:
                self._categories[instance] = owner.category
            self._objects[stands] = instance, owner.classes
        return self._objects[stands]

    def _owner(self, path: str, instance: str) -> "_Owner":
        chain = self._ancestry.of(path)
        labelled = _from_first(chain, self._is_labelled)
        found = labelled or _from_first(chain, Usd.Prim.IsComponent)
        place = found[0][0] if found else path
        prims = [prim for _, prim in labelled]
        classes = tuple(read_number(prims, name) for name in CLASS_CHANNELS)
        is_in_instance = bool(instance) and place.startswith(instance)
        place = place.removeprefix(instance) if is_in_instance else place
        return _Owner(place, is_in_instance, read_category(prims), classes)

    def _is_labelled(self, prim: Usd.Prim) -> bool:
        path = prim.GetPath()
        if path not in self._labelled:
            self._labelled[path] = is_labelled(prim)
        return self._labelled[path]


@dataclass(frozen=True)
class _Owner:
    """The object that surfaces are part of.

    Attributes:
        place: Where it stands, in the instance of a point instancer where it is in one.
        is_in_instance: Whether it is.
        category: What it is.
        classes: Numbers of its classes.
    """

    place: str
    is_in_instance: bool
    category: str | None
    classes: tuple[int, ...]


def _from_first(chain: tuple[Stand, ...], test: Callable[[Usd.Prim], bool]) -> tuple[Stand, ...]:
    """From the first of a chain for which a test holds; empty where it holds for none."""
    return next((chain[at:] for at, (_, prim) in enumerate(chain) if test(prim)), ())


def material_path(material: UsdShade.Material | None) -> str | None:
    """The path of a material, or None."""
    return None if material is None else str(material.GetPath())


def _number(numbers: dict[str, int], name: str) -> int:
    return numbers.setdefault(name, len(numbers) + 1)


def _names(numbers: dict[str, int]) -> dict[int, str]:
    return {number: name for name, number in numbers.items()}
