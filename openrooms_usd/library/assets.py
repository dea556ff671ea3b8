"""Component assets: a light interface layer over a payload of meshes, published once.

::

    chair_1a2b3c4d/
        chair_1a2b3c4d.usda   default prim Chair: kind, class, assetInfo, extentsHint, label
        geometry.usdc         its payload: Geometry/<part> or, where some parts move,
                              Geometry/Body/<part> and Geometry/<joint>/<part>; for foreign
                              models also Materials/<name>
        textures/             the pictures of foreign models
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.atomic import replacing_folder
from openrooms_usd.codedigest import code_digest
from openrooms_usd.errors import InputError
from openrooms_usd.furniture.joinery.pieces import Furniture, Joint, part_of
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.timber import grained

if TYPE_CHECKING:
    from pxr import Sdf, Usd

    from openrooms_usd.usd.shading.materials import PreviewSurface

GEOMETRY: Final = "geometry.usdc"
# The Xform below Geometry that holds the fixed parts of an object whose other parts move.
BODY: Final = "Body"


@dataclass(frozen=True, eq=False)
class Model:
    """What an asset holds.

    Attributes:
        parts: Meshes by prim name, in the object frame: metres, Z up, origin in the middle of the
            base, front towards -Y.
        titles: The original names of parts that could not be prim names as they were.
        surfaces: The material of parts that bring their own; texture files are absolute paths.
        notes: What was left out or mended, one sentence each.
        double_sided: Whether its surfaces may be open and seen from behind.
        licence: The terms that a foreign model states; empty where it states none.
        joints: How some of the parts move.
        file_from_object: (4, 4) takes points of the object frame to the coordinates of the file
            that a foreign model is from.
    """

    parts: Mapping[str, Mesh]
    titles: Mapping[str, str] = field(default_factory=dict)
    surfaces: Mapping[str, "PreviewSurface"] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    double_sided: bool = False
    licence: str = ""
    joints: tuple[Joint, ...] = ()
    file_from_object: Array = field(default_factory=lambda: np.eye(4))

    @property
    def extent(self) -> Array:
        """(2, 3) least and greatest coordinates, metres."""
        extents = np.stack([mesh.extent for mesh in self.parts.values()])
        return np.stack([extents[:, 0].min(axis=0), extents[:, 1].max(axis=0)])


def model_of(furniture: Furniture) -> Model:
    """Furniture of the library, under our licence."""
    return Model(grained(furniture.parts), joints=furniture.joints, licence=names.LICENCE)


@dataclass(frozen=True)
class Asset:
    """An asset to be: what determines it, and how to make it.

    Attributes:
        category: What it is; labels its root.
        key: Plain data that determines its content, together with code.
        build: Makes it.
        code: The modules that ``build`` runs; none where the key holds what they made.
    """

    category: str
    key: tuple[Any, ...]
    build: Callable[[], Model] = field(compare=False)
    code: tuple[str, ...] = ()

    @cached_property
    def name(self) -> str:
        """The category and 8 hexadecimal digits of what determines the content."""
        code = code_digest(__name__, *self.code)
        text = json.dumps([code, self.category, *self.key])
        return f"{self.category}_{hashlib.sha256(text.encode()).hexdigest()[:8]}"

    @property
    def file(self) -> str:
        """Its interface layer, relative to the folder of all assets."""
        return f"{self.name}/{self.name}.usda"

    @property
    def prim(self) -> str:
        """The name of its default prim: ``FloorLamp`` for ``floor_lamp``."""
        return "".join(word[:1].upper() + word[1:] for word in self.category.split("_"))


def publish(folder: Path, asset: Asset) -> str:
    """Write an asset, whole or not at all; nothing happens when it is there already.

    Args:
        folder: Where all assets lie.
        asset: What to publish.

    Returns:
        The path of its interface layer relative to ``folder``.

    Raises:
        OutputError: It cannot be written.
    """
    target = folder / asset.name
    if not (target / f"{asset.name}.usda").is_file():
        model = asset.build()
        with replacing_folder(target) as beside:
            pictures = _copy_textures(model, beside)
            _write_geometry(asset, pictures, beside / GEOMETRY)
            _write_interface(asset, model, beside / f"{asset.name}.usda")
    return asset.file


def _copy_textures(model: Model, folder: Path) -> Model:
    """Copy the textures of foreign surfaces, and point the surfaces at the copies."""
    from openrooms_usd.usd.shading.materials import Texture

    surfaces = {}
    for part, surface in model.surfaces.items():
        copied: dict[str, Texture] = {}
        for name, value in vars(surface).items():
            if isinstance(value, Texture):
                content = read_asset(value.file)
                suffix = Path(value.file.rstrip("]")).suffix.lower()
                file = f"textures/{hashlib.sha256(content).hexdigest()[:12]}{suffix}"
                (folder / "textures").mkdir(exist_ok=True)
                (folder / file).write_bytes(content)
                copied[name] = replace(value, file=f"./{file}")
        surfaces[part] = replace(surface, **copied)  # type: ignore[arg-type]
    return replace(model, surfaces=surfaces)


def read_asset(path: str) -> bytes:
    """The bytes of a file, which may lie inside a package (``/x/y.usdz[0/z.png]``).

    Raises:
        InputError: There is no such file.
    """
    from pxr import Ar

    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
    if not asset:
        raise InputError("no such file", place=path, remedy="check the model's textures")
    with asset:
        return bytes(asset.GetBuffer())


def _new_stage(asset: Asset) -> "tuple[Usd.Stage, Usd.Prim]":
    """A stage in memory with our metadata and the asset's root prim."""
    from pxr import Usd, UsdGeom

    from openrooms_usd.usd.files.layers import apply_metadata

    stage = Usd.Stage.CreateInMemory(load=Usd.Stage.LoadNone)
    apply_metadata(stage.GetRootLayer())
    root = UsdGeom.Xform.Define(stage, f"/{asset.prim}").GetPrim()
    stage.SetDefaultPrim(root)
    return stage, root


def _write_geometry(asset: Asset, model: Model, target: Path) -> None:
    from pxr import UsdGeom

    from openrooms_usd.usd.files.layers import export
    from openrooms_usd.usd.semantics import label_part
    from openrooms_usd.usd.shapes.meshes import define_mesh

    stage, root = _new_stage(asset)
    geometry = UsdGeom.Scope.Define(stage, root.GetPath().AppendChild("Geometry")).GetPath()
    # What moves cannot be inside of what carries it: rigid bodies are never nested.
    fixed = geometry.AppendChild(BODY) if model.joints else geometry
    if model.joints:
        UsdGeom.Xform.Define(stage, fixed)
    groups = _define_joints(stage, geometry, model)
    paths = {}
    for name, mesh in model.parts.items():
        parent, origin = groups.get(name, (fixed, (0.0, 0.0, 0.0)))
        paths[name] = parent.AppendChild(name)
        local = mesh.moved(-np.array(origin)) if any(origin) else mesh
        prim = define_mesh(stage, paths[name], local, double_sided=model.double_sided).GetPrim()
        label_part(prim, part_of(name))
        if name in model.titles:
            prim.SetDisplayName(model.titles[name])
    _bind_surfaces(stage, root, paths, model)
    export(stage.GetRootLayer(), target)


def _define_joints(
    stage: "Usd.Stage", geometry: "Sdf.Path", model: Model
) -> "dict[str, tuple[Sdf.Path, tuple[float, float, float]]]":
    """Define an Xform for each joint, its pivot in its origin.

    Returns:
        The Xform and its origin, by the name of each mesh that belongs below it.
    """
    from pxr import Gf, UsdGeom

    from openrooms_usd.usd.places.frames import author_placement
    from openrooms_usd.usd.semantics import label_part
    from openrooms_usd.usd.shading.physics import author_joint

    groups: dict[str, tuple[Sdf.Path, tuple[float, float, float]]] = {}
    for joint in model.joints:
        path = geometry.AppendChild(f"{joint.name}_{joint.kind}")
        prim = UsdGeom.Xform.Define(stage, path).GetPrim()
        author_placement(prim, Gf.Vec3d(*joint.origin), 0.0)
        author_joint(prim, joint.kind, joint.axis, joint.limits)
        label_part(prim, part_of(joint.name))
        groups |= dict.fromkeys(joint.meshes, (path, joint.origin))
    return groups


def _bind_surfaces(
    stage: "Usd.Stage", root: "Usd.Prim", paths: "Mapping[str, Sdf.Path]", model: Model
) -> None:
    """Define each distinct surface once and bind it to its parts."""
    from pxr import UsdGeom, UsdShade

    from openrooms_usd.usd.shading.materials import define_preview_surface

    if not model.surfaces:
        return
    scope = UsdGeom.Scope.Define(stage, root.GetPath().AppendChild("Materials")).GetPath()
    defined: list[tuple[PreviewSurface, UsdShade.Material]] = []
    for part, surface in model.surfaces.items():
        known = next((material for other, material in defined if other == surface), None)
        material = known or define_preview_surface(
            stage, scope.AppendChild(f"material_{len(defined)}"), surface
        )
        if known is None:
            defined.append((surface, material))
        prim = stage.GetPrimAtPath(paths[part])
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


def _write_interface(asset: Asset, model: Model, target: Path) -> None:
    from pxr import Gf, Kind, Sdf, Usd, UsdGeom, Vt

    from openrooms_usd.usd.files.layers import export
    from openrooms_usd.usd.semantics import label

    stage, root = _new_stage(asset)
    parent = stage.CreateClassPrim("/__class__")
    parent.SetTypeName("Scope")
    shared = stage.CreateClassPrim(f"/__class__/{asset.prim}")
    shared.SetTypeName("Xform")
    root.GetInherits().AddInherit(shared.GetPath())
    root.GetPayloads().AddPayload(f"./{GEOMETRY}")
    api = Usd.ModelAPI(root)
    api.SetKind(Kind.Tokens.component)
    api.SetAssetName(asset.name)
    api.SetAssetIdentifier(Sdf.AssetPath(f"./{asset.name}.usda"))
    if model.licence:
        root.SetAssetInfoByKey(names.LICENCE_KEY, model.licence)
    extent = [Gf.Vec3f(*row) for row in model.extent.astype(np.float32).tolist()]
    UsdGeom.ModelAPI.Apply(root).SetExtentsHint(Vt.Vec3fArray(extent))
    label(root, asset.category)
    export(stage.GetRootLayer(), target)
