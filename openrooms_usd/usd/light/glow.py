"""Lamps for programs without mesh lights: the materials of their bulbs emit, too."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd import names
from openrooms_usd.usd.light.lightreader import read_light
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.shading.materialreader import preview_shader
from openrooms_usd.usd.shading.materials import bound_material


def author_glow(stage: Usd.Stage, root: Sdf.Path, bulbs: Sequence[Sdf.Path]) -> Iterator[str]:
    """Let the materials of a lamp's bulbs emit what its mesh lights do, in each of its looks.

    The radiance is that of the composed stage: what people have set in the edits counts. Opinions
    are written where they change something.

    Args:
        stage: The composed stage, its edit target set to the layer to write.
        root: The lamp.
        bulbs: Its mesh lights.

    Yields:
        A sentence for each material that stays dark, because it is not the bulbs' alone.
    """
    layer = stage.GetEditTarget().GetLayer()
    looks = stage.GetPrimAtPath(root).GetVariantSets().GetVariantSet(names.LOOK).GetVariantNames()
    # What a variant switches is written inside it; a single look needs no variant.
    for look in looks if len(looks) > 1 else ("",):
        with _wearing(stage, root, look):
            glows, shared = _glows(stage, root, bulbs)
        home = _inside(layer, root, look)
        for shader, radiance in glows.items():
            _author(layer, shader.ReplacePrefix(root, home), radiance)
        for material in shared:
            yield (
                f"{root.name}: other objects share the material of its bulb, so {material} has no "
                "emission: programs without mesh lights show this lamp dark"
            )


@contextmanager
def _wearing(stage: Usd.Stage, root: Sdf.Path, look: str) -> Iterator[None]:
    """The lamp in one of its looks, whichever is chosen. Prims in hand may be made anew by it."""
    session = stage.GetSessionLayer()
    if look:
        Sdf.CreatePrimInLayer(session, root).variantSelections[names.LOOK] = look
    yield
    session.Clear()


def _inside(layer: Sdf.Layer, root: Sdf.Path, look: str) -> Sdf.Path:
    """Where opinions about one look of the lamp go."""
    if not look:
        return root
    Sdf.CreateVariantInLayer(layer, root, names.LOOK, look)
    return root.AppendVariantSelection(names.LOOK, look)


def _glows(
    stage: Usd.Stage, root: Sdf.Path, bulbs: Sequence[Sdf.Path]
) -> tuple[dict[Sdf.Path, Gf.Vec3f], list[Sdf.Path]]:
    """The radiance of each shader that shall emit otherwise; and materials that others wear."""
    others = _other_materials(stage.GetPrimAtPath(root), bulbs)
    glows: dict[Sdf.Path, Gf.Vec3f] = {}
    shared: dict[Sdf.Path, None] = {}
    for bulb in map(stage.GetPrimAtPath, bulbs):
        material, radiance = bound_material(bulb), _radiance(bulb)
        shader = preview_shader(material) if material else None
        if material is None or shader is None or radiance is None or _emits(shader, radiance):
            continue
        # Materials below the lamp are bound by nothing outside it.
        if material.GetPath().HasPrefix(root) and material.GetPath() not in others:
            glows[shader.GetPath()] = radiance
        else:
            shared[material.GetPath()] = None
    return glows, list(shared)


def _other_materials(root: Usd.Prim, bulbs: Iterable[Sdf.Path]) -> set[Sdf.Path]:
    """The materials of a lamp's other parts."""
    lit = set(bulbs)
    parts = [p for p in Usd.PrimRange(root) if p.IsA(UsdGeom.Gprim) or p.IsA(UsdGeom.Subset)]
    worn = [bound_material(part) for part in parts if part.GetPath() not in lit]
    return {material.GetPath() for material in worn if material}


def _radiance(bulb: Usd.Prim) -> Gf.Vec3f | None:
    """Nits of each primary; None where the material tints the light, or turns it off."""
    light = UsdLux.LightAPI(bulb)
    mode = light.GetMaterialSyncModeAttr()
    if not light or mode.Get(TIME) != UsdLux.Tokens.noMaterialResponse:
        return None
    return Gf.Vec3f(*read_light(bulb).radiance.tolist())


def _emits(shader: UsdShade.Shader, radiance: Gf.Vec3f) -> bool:
    """Whether a shader emits that already, or what is connected to it."""
    emission = shader.GetInput("emissiveColor")
    if not emission:
        return bool(radiance == Gf.Vec3f(0.0))
    return bool(emission.HasConnectedSource() or emission.Get(TIME) == radiance)


def _author(layer: Sdf.Layer, shader: Sdf.Path, radiance: Gf.Vec3f) -> None:
    spec = Sdf.CreatePrimInLayer(layer, shader)
    Sdf.AttributeSpec(spec, "inputs:emissiveColor", Sdf.ValueTypeNames.Color3f).default = radiance
