"""Another model in the place of an object: of any category and style of the library.

The object keeps its path and its place, so that what speaks about it, stands on it or is relative
to it still finds it. Model and look lie in ``layers/edits``; the edits alone refer to both,
and what earlier layers refer to counts no more.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.edits.arranging import Standing, standing
from openrooms_usd.edits.assigning import context_of
from openrooms_usd.edits.editing import editing
from openrooms_usd.edits.targets import furniture
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES, category, styles
from openrooms_usd.library.assets import Asset, publish
from openrooms_usd.stages.alignment.catalogue import Catalogue
from openrooms_usd.stages.alignment.stage import ASSETS
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.materials.dressing import Chooser, Dresser
from openrooms_usd.stages.materials.looks import publish_look
from openrooms_usd.stages.materials.palette import Palette
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.places.placements import author_placed
from openrooms_usd.usd.semantics import label, read_label

_DIGITS: Final = 4


def choices(kind: str, size: Sequence[float]) -> tuple[str, ...]:
    """The styles in which the library makes a category in about this size; none of others."""
    if kind not in CATEGORIES:
        return ()
    width, depth, height = size
    return styles(kind, (width, depth, height))


def remake(
    scene: Path, name: str, style: str, kind: str | None = None, *, keep_size: bool = True
) -> Standing:
    """Let the library make an object anew.

    Args:
        scene: The ``scene.usda`` of the room.
        name: The object.
        style: One of the category's styles.
        kind: Its category; None for what it is.
        keep_size: Whether it is as large as before, or as large as such a thing usually is.

    Raises:
        InputError: There is no such object, category or style, or this is no composed room.
        OutputError: The edits or a model cannot be written.
        StageError: The room would not compose.
    """
    with editing(scene) as stage:
        prim = furniture(stage, name)
        wanted = kind or read_label(prim, names.CATEGORY) or ""
        known = category(wanted)
        if style not in known.styles:
            raise InputError(
                f"no {wanted} has the style {style!r}", remedy=f"known: {', '.join(known.styles)}"
            )
        usual = known.styles[style].size or known.size
        width, depth, height = standing(prim).size if keep_size else usual
        size = (round(width, _DIGITS), round(depth, _DIGITS), round(height, _DIGITS))
        context = context_of(stage, scene)
        asset = Catalogue(context).furniture(wanted, size, style)
        layer = stage.GetEditTarget().GetLayer()
        spec = Sdf.CreatePrimInLayer(layer, prim.GetPath())
        # What was edited of the parts of the old model finds them no more.
        for child in list(spec.nameChildren):
            del spec.nameChildren[child.name]
        # The place of a copy is in part that of its original, which it refers to no more.
        local = UsdGeom.Xformable(prim).GetLocalTransformation(TIME)
        give_model(context, spec, prim, asset)
        spec.instanceable = not known.emits
        label(prim, wanted)
        _unscale(spec, prim, local)
        return standing(prim)


def give_model(context: StageContext, spec: Sdf.PrimSpec, prim: Usd.Prim, asset: Asset) -> None:
    """Let an object refer to a model and to a look for it, both beside the edits.

    Args:
        context: As `openrooms_usd.edits.assigning.context_of` has it.
        spec: The object in the edits.
        prim: The same in the composed stage.
        asset: Published where it is not there yet.

    Raises:
        OutputError: A file cannot be written.
    """
    model = context.asset(f"{ASSETS}/{publish(context.folder / ASSETS, asset)}")
    _refer(spec, [model])
    _refer(spec, [*_look(context, prim), model])


def _refer(spec: Sdf.PrimSpec, files: Sequence[str]) -> None:
    """Refer to these files alone; of an object of the edits, beside the body that physics gives."""
    references = [Sdf.Reference(file) for file in files]
    if spec.specifier == Sdf.SpecifierDef:
        spec.referenceList.ClearEdits()
        spec.referenceList.prependedItems = references
    else:
        spec.referenceList.ClearEditsAndMakeExplicit()
        spec.referenceList.explicitItems = references


def _look(context: StageContext, prim: Usd.Prim) -> list[str]:
    """A look for the model as the tables have it; none for one that brings its own materials."""
    look = Dresser(context, (Chooser(context),), {}).dressed(prim)
    if not look.looks[0]:
        return []
    palette = Palette(context)
    palette.publish(look.looks[0].values())
    return [publish_look(context, palette, look)]


def _unscale(spec: Sdf.PrimSpec, prim: Usd.Prim, local: Gf.Matrix4d) -> None:
    """Keep the place without its scale: the model is made in its size."""
    scale = np.linalg.norm(np.array(local)[:3, :3], axis=1)
    author_placed(spec, prim, Gf.Matrix4d().SetScale(Gf.Vec3d(*(1.0 / scale).tolist())) * local)
