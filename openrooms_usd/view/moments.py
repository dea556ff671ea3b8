"""The light of a room at one moment or at several: lightmaps of the same surfaces."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from pxr import Usd

from openrooms_usd import names, untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.bake.baking import LIT
from openrooms_usd.rendering.bake.layer import ATLAS, IRRADIANCE, SCALE_OFFSET
from openrooms_usd.usd.files.diagnostics import reading
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.places.frames import TIME

# By prim: its part of an atlas, the atlas, and its coordinates as a digest.
Places: TypeAlias = dict[str, tuple[object, ...]]

_COORDINATES = f"primvars:{names.BAKED_ST}"


@dataclass(frozen=True, eq=False)
class Moment:
    """A room in the light of a moment.

    Attributes:
        name: What it is called.
        file: The stage with its lightmaps.
        stage: That stage.
        is_own: Whether what was baked is the stage that is looked at.
    """

    name: str
    file: Path
    stage: Usd.Stage
    is_own: bool


def moments_of(path: Path, folders: Sequence[Path]) -> tuple[Moment, ...]:
    """The moments of a stage, as they are given.

    Args:
        path: The stage that is looked at.
        folders: What `orusd bake` wrote: of this stage, and of others with the same surfaces.

    Raises:
        InputError: A folder holds no lightmaps, all are of other stages, or one is of another room.
    """
    moments = tuple(
        _moment(path, folder, name)
        for folder, name in zip(folders, _names_of(folders), strict=True)
    )
    own = next((one for one in moments if one.is_own), None)
    if moments and own is None:
        raise InputError(
            "these lightmaps belong to another stage",
            place=folders[0],
            remedy=f"orusd bake {path} -o FOLDER, or view the stage that was baked",
        )
    places = _places(own.stage) if own and len(moments) > 1 else {}
    for one, folder in zip(moments, folders, strict=True):
        if one is not own and _places(one.stage) != places:
            raise InputError(
                "these lightmaps belong to another room, or have another layout",
                place=folder,
                remedy="bake all moments with the same --texel and --max-texels, of rooms that "
                "differ only in their environment",
            )
    return moments


def _names_of(folders: Sequence[Path]) -> list[str]:
    """By their own names, or with those of the folders that they are in."""
    short = [folder.resolve().name for folder in folders]
    if len(set(short)) == len(short):
        return short
    return ["/".join(folder.resolve().parts[-2:]) for folder in folders]


def _moment(path: Path, folder: Path, name: str) -> Moment:
    file = folder / LIT
    stage = open_stage(file) if untrusted.kind_of(file) == "a file" else None
    if stage is None or not atlases_of(stage):
        raise InputError(
            "there are no lightmaps", place=folder, remedy=f"orusd bake {path} -o {folder}"
        )
    baked = {Path(layer.realPath).resolve() for layer in stage.GetLayerStack(False)}
    return Moment(name, file, stage, path.resolve() in baked)


def atlases_of(stage: Usd.Stage) -> list[Usd.Prim]:
    """The prims that say what pictures lightmaps are."""
    return [x for x in stage.Traverse() if x.GetAttribute(IRRADIANCE).HasAuthoredValue()]


def _places(stage: Usd.Stage) -> Places:
    """Where every surface lies in which lightmap."""
    found: Places = {}
    with reading(stage.GetRootLayer().realPath):
        for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
            part, st = (prim.GetAttribute(name) for name in (SCALE_OFFSET, _COORDINATES))
            if part.HasAuthoredValue() or st.HasAuthoredValue():
                targets = prim.GetRelationship(ATLAS).GetTargets()
                coordinates = bytes(memoryview(st.Get(TIME) or b""))
                digest = hashlib.sha256(coordinates).hexdigest()
                found[str(prim.GetPath())] = (part.Get(TIME), tuple(targets), digest)
    return found
