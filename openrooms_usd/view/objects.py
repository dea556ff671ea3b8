"""The page in which people move furniture, and say what it is."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from pydantic import Field

from openrooms_usd import names
from openrooms_usd.description.furniture import Size
from openrooms_usd.description.model import Model
from openrooms_usd.description.units import Angle, Length
from openrooms_usd.edits.arranging import Standing, settled, standing
from openrooms_usd.edits.remaking import choices
from openrooms_usd.edits.snapping import PlanPoint
from openrooms_usd.edits.targets import all_furniture, furniture
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.steps.alignment.surroundings import surroundings
from openrooms_usd.usd.files.diagnostics import quiet
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.validation.room_rules import about
from openrooms_usd.view.app import App, Command
from openrooms_usd.view.corrections import Corrections
from openrooms_usd.view.room import room_glb, room_state


class _Named(Model):
    """An object."""

    name: str = Field(max_length=4096)


class _Spot(_Named):
    """Where it shall be."""

    x: Length
    y: Length
    yaw: Angle
    snap: bool = True


class _Placed(_Spot):
    """And how large."""

    size: Size | None = None


class _Labelled(_Named):
    """What it is called."""

    category: str


class _Remade(_Named):
    """What the library shall make in its place."""

    category: str
    style: str
    keep_size: bool = True


def objects_app(held: Corrections) -> App:
    """The page in which people correct the furniture of a room.

    Args:
        held: The room, and where what they do is written.
    """
    scene, target = held.target.scene, held.target

    def tried(given: _Spot) -> dict[str, Any]:
        """Where an object would come to stand; nothing is written."""
        with quiet():
            stage = open_stage(scene)
            thing, spot = standing(furniture(stage, given.name)), _spot(given)
            return (
                settled(surroundings(stage), thing, spot)._asdict()
                if given.snap
                else spot._asdict()
            )

    def changed(change: Callable[[], Standing]) -> dict[str, Any]:
        """Tell of an object that was changed, and what is wrong with where it stands now."""
        done = held.done(lambda: _object_record(change()))
        with quiet():
            return {**done, "warnings": about(open_stage(scene), done["object"]["path"])}

    def placed(given: _Placed) -> dict[str, Any]:
        spot = _spot(given)
        return changed(lambda: target.place(given.name, spot, size=given.size, snap=given.snap))

    def removed(given: _Named) -> dict[str, Any]:
        def change() -> dict[str, Any]:
            target.remove(given.name)
            return {}

        return held.done(change)

    def remade(given: _Remade) -> dict[str, Any]:
        kind, keep = given.category, given.keep_size
        return changed(lambda: target.remake(given.name, given.style, kind, keep_size=keep))

    return App(
        page="objects",
        title=f"{scene.resolve().parent.name}: objects",
        state=lambda: _state(held),
        resources={"room.glb": lambda: room_glb(scene)},
        commands={
            "try": Command(_Spot, tried),
            "place": Command(_Placed, placed),
            "remake": Command(_Remade, remade),
            "remove": Command(_Named, removed),
            "duplicate": Command(
                _Named, lambda given: changed(lambda: target.duplicate(given.name))
            ),
            "relabel": Command(
                _Labelled, lambda given: changed(lambda: target.relabel(given.name, given.category))
            ),
            **held.commands(),
        },
        watched=(held.history.file,),
    )


def _state(held: Corrections) -> dict[str, Any]:
    """The state of the room for the page."""
    scene = held.target.scene
    stage = open_stage(scene)
    return {
        **room_state(scene),
        **held.told(),
        "objects": [_object_record(standing(prim))["object"] for prim in all_furniture(stage)],
        "categories": {name: list(CATEGORIES[name].styles) for name in sorted(CATEGORIES)},
        "floor": surroundings(stage).floor,
    }


def _spot(given: _Spot) -> PlanPoint:
    return PlanPoint(given.x, given.y, given.yaw)


def _object_record(thing: Standing) -> dict[str, Any]:
    """An object, with the styles in which the library would make it."""
    styles = choices(thing.category, thing.size)
    path = f"{names.FURNITURE}/{thing.name}"
    return {"object": {**asdict(thing), "path": path, "styles": list(styles)}}
