"""The page in which people say what things are made of."""

from collections.abc import Iterator, Mapping
from typing import Any, Final

from pxr import Usd
from pydantic import Field

from openrooms_usd import names
from openrooms_usd.description.model import Model
from openrooms_usd.edits.targets import SCOPES, Scope
from openrooms_usd.errors import InputError
from openrooms_usd.library.textures import FAMILIES, family_of
from openrooms_usd.library.thumbnails import thumbnail
from openrooms_usd.steps.materials.dressing import NUMBERS_PER_FAMILY
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.shading.materials import bound_material
from openrooms_usd.view.app import App, Command
from openrooms_usd.view.corrections import Corrections
from openrooms_usd.view.room import room_glb, room_state

_PICTURES: Final = "material"


class _Meant(Model):
    """A part, and how much is meant by pointing at it."""

    path: str = Field(max_length=4096)
    scope: Scope


class _Assigned(_Meant):
    """What that is made of, as a room.yaml says it."""

    look: str | dict[str, Any]


class _Pictures(Mapping[str, Any]):
    """Pictures of materials, ``material/FAMILY/NUMBER.png``, beside other resources."""

    def __init__(self, others: Mapping[str, Any]) -> None:
        self._others = others

    def __getitem__(self, name: str) -> Any:
        if name in self._others:
            return self._others[name]
        kind, _, rest = name.partition("/")
        family, _, number = rest.removesuffix(".png").partition("/")
        known = any(family in families for families in FAMILIES.values())
        if kind != _PICTURES or not known or number not in _NUMBERS:
            raise KeyError(name)
        return lambda: thumbnail(family, int(number))

    def __iter__(self) -> Iterator[str]:
        return iter(self._others)

    def __len__(self) -> int:
        return len(self._others)


_NUMBERS: Final = frozenset(map(str, range(NUMBERS_PER_FAMILY)))


def materials_app(held: Corrections) -> App:
    """The page in which people choose the materials of a room.

    Args:
        held: The room, and where what they choose is written.
    """
    scene, target = held.target.scene, held.target

    def assigned(given: _Assigned) -> dict[str, Any]:
        if isinstance(given.look, dict) and "file" in given.look:
            raise InputError(
                "a page can only choose materials of the library, not files",
                remedy="write your own material into the room.yaml, or into the edits",
            )

        def change() -> dict[str, Any]:
            done = target.assign(given.path, given.scope, given.look)
            return {"material": done.material, "parts": list(done.parts)}

        return held.done(change)

    def reset(given: _Meant) -> dict[str, Any]:
        return held.done(
            lambda: {"parts": list(target.unassign(given.path, given.scope).parts)}, bares=True
        )

    def state() -> dict[str, Any]:
        return {
            **room_state(scene),
            **held.told(),
            "made": _substances(open_stage(scene)),
            "scopes": SCOPES,
            "numbers": NUMBERS_PER_FAMILY,
            "library": {
                substance: {name: family_of(name).size for name in families}
                for substance, families in FAMILIES.items()
            },
        }

    return App(
        page="materials",
        title=f"{scene.resolve().parent.name}: materials",
        state=state,
        resources=_Pictures({"room.glb": lambda: room_glb(scene)}),
        commands={
            "assign": Command(_Assigned, assigned),
            "reset": Command(_Meant, reset),
            **held.commands(),
        },
        watched=(held.history.file,),
    )


def _substances(stage: Usd.Stage) -> dict[str, dict[str, Any]]:
    """What each surface is made of: substance, family and number of its material."""
    found: dict[str, dict[str, Any]] = {}
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        material = bound_material(prim)
        if material is None:
            continue
        said = {
            "substance": names.MATERIAL_CATEGORY,
            "family": names.MATERIAL_FAMILY,
            "number": names.MATERIAL_NUMBER,
        }
        values = {key: material.GetPrim().GetAttribute(name) for key, name in said.items()}
        row = {key: value.Get() for key, value in values.items() if value and value.HasValue()}
        found[str(prim.GetPath())] = {"material": material.GetPrim().GetName(), **row}
    return found
