"""What is registered as entry points: three exporters that load USD when they are used."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd.errors import InputError
from openrooms_usd.exporters import Report
from openrooms_usd.spelling import did_you_mean

if TYPE_CHECKING:
    from pxr import Usd

# What an option may be, and how that is said to people.
_Rule = tuple[Callable[[Any], bool], str]

_FRICTION: Final[_Rule] = (lambda value: value in ("static", "dynamic"), "static or dynamic")
_PAIRS: Final[_Rule] = (
    lambda value: value in ("auto", "all", "near", "close", "none"),
    "auto, all, near, close or none",
)
_FLAG: Final[_Rule] = (lambda value: isinstance(value, bool), "true or false")
_PACKAGE: Final[_Rule] = (
    lambda value: isinstance(value, str) and value.isidentifier() and value.isascii(),
    "a name of letters, digits and underscores",
)


class UrdfExporter:
    """Writes a stage as a URDF for every object and one for the room, with a file of places."""

    def convert(self, stage: "Usd.Stage", destination: Path, options: Mapping[str, Any]) -> Report:
        """Write ``stage`` into the folder ``destination``.

        Args:
            stage: The composed stage, with rigid bodies.
            destination: The folder.
            options: ``friction``: which coefficient counts, ``static`` (without it) or
                ``dynamic``. ``package``: the name of the ROS package that the folder will be;
                files are then named ``package://NAME/...`` instead of relatively.

        Raises:
            InputError: An option is not known.
            StageError: A body is impossible.
            OutputError: The destination cannot be written.
        """
        _check(options, {"friction": _FRICTION, "package": _PACKAGE}, "URDF")
        from openrooms_usd.usd.rigid.reading import read_world
        from orusd_urdf.looks import read_looks
        from orusd_urdf.reports import export_report
        from orusd_urdf.urdf import write_urdf

        world = read_world(stage)
        looks = read_looks(stage, world)
        notes = write_urdf(world, destination, looks=looks.looks, **options)
        return export_report(stage, world, [*looks.losses, *notes])


class MjcfExporter:
    """Writes a stage as one MJCF scene with its meshes and textures."""

    def convert(self, stage: "Usd.Stage", destination: Path, options: Mapping[str, Any]) -> Report:
        """Write ``stage`` as ``scene.xml`` into the folder ``destination``.

        Args:
            stage: The composed stage, with rigid bodies.
            destination: The folder.
            options: ``friction``: which coefficient counts, ``static`` (without it) or
                ``dynamic``. ``pairs``: which unequal surfaces get the coefficient that
                they have together: ``all``, those that are ``near`` each other at first or meet
                the room, those that are ``close`` to each other or the room, or ``none``; others
                the larger one. MuJoCo looks at every pair in every step: ``auto`` (without it) is
                the first of these that are at most 100,000, and at least those that are close.

        Raises:
            InputError: An option is not known.
            StageError: A body is impossible.
            OutputError: The destination cannot be written.
        """
        _check(options, {"friction": _FRICTION, "pairs": _PAIRS}, "MJCF")
        from openrooms_usd.usd.rigid.reading import read_world
        from orusd_urdf.looks import read_looks
        from orusd_urdf.mjcf import write_mjcf
        from orusd_urdf.reports import export_report

        world = read_world(stage)
        looks = read_looks(stage, world)
        notes = write_mjcf(world, destination, looks=looks.looks, **options)
        return export_report(stage, world, [*looks.losses, *notes])


class UsdPhysicsExporter:
    """Writes a stage as one flat USD file with its textures, for Isaac Sim and Newton."""

    def convert(self, stage: "Usd.Stage", destination: Path, options: Mapping[str, Any]) -> Report:
        """Write ``stage`` as ``scene.usdc`` into the folder ``destination``.

        Args:
            stage: The composed stage, with rigid bodies.
            destination: The folder.
            options: ``roots``: whether coefficients are written as their roots, to be multiplied
                (``true`` without it). An engine that does not know PhysX' way to combine them
                needs ``false``; its pairs are then as it combines them.

        Raises:
            InputError: An option is not known.
            StageError: A body is impossible.
            OutputError: The destination cannot be written.
        """
        _check(options, {"roots": _FLAG}, "UsdPhysics")
        from openrooms_usd.usd.rigid.reading import read_world
        from orusd_urdf.reports import export_report
        from orusd_urdf.usdphysics import write_usdphysics

        world = read_world(stage)
        notes = write_usdphysics(stage, world, destination, **options)
        return export_report(stage, world, notes, seen=True)


def _check(options: Mapping[str, Any], known: Mapping[str, _Rule], kind: str) -> None:
    for name, value in options.items():
        if name not in known:
            hint = did_you_mean(name, known)
            raise InputError(
                f"the {kind} exporter has no option {name!r}{hint}",
                remedy=f"use {', '.join(known)}",
            )
        fits, wanted = known[name]
        if not fits(value):
            raise InputError(f"{name} is {value!r}", remedy=f"give {wanted}")
