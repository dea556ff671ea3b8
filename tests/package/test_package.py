"""A flattened and a packaged scene compose to what the layered one composes to."""

import hashlib
import os
import shutil
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Ar, Sdf, Usd, UsdMedia, UsdUtils

from openrooms_usd.errors import InputError, OrusdError, OutputError, StageError
from openrooms_usd.package import flatten, package
from openrooms_usd.rules import validate_stage
from openrooms_usd.usd.files.diagnostics import quiet

HEADER = """#usda 1.0
(
    customLayerData = {
        string creator = "openrooms_usd"
        dictionary openrooms = {
            dictionary stages = {
                dictionary %(stage)s = {
                    string fingerprint = "%(stage)s"
                }
            }
        }
    }
    defaultPrim = "%(prim)s"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
    %(more)s
)
"""
LAYOUT = """
def Xform "World" (
    kind = "assembly"
    prepend apiSchemas = ["AuthorshipAPI:layout"]
)
{
    string authorship:layout:softwareVersion = "1"

    def Mesh "Floor"
    {
        float3[] extent = [(0, 0, 0), (1, 1, 0)]
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        uniform token subdivisionScheme = "none"
    }
}
"""
ALIGNMENT = """
over "World"
{
    def Xform "chair_0" (
        instanceable = true
        prepend references = [@./materials/looks/look.usda@, @./alignment/chair.usda@]
        variants = {
            string look = "dark"
        }
    )
    {
    }

    def Xform "chair_1" (
        instanceable = true
        prepend references = [@./materials/looks/look.usda@, @./alignment/chair.usda@]
    )
    {
        double3 xformOp:translate = (1, 2, 3)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""
CHAIR = """
class Xform "Class"
{
}

def Xform "Chair" (
    kind = "component"
    inherits = </Class>
    payload = @./geometry.usda@
)
{
}
"""
GEOMETRY = """
def Xform "Chair"
{
    def Scope "Geometry"
    {
        def Sphere "seat"
        {
            double radius = 0.25
        }
    }
}
"""
LOOK = """
def Xform "Chair" (
    variants = {
        string look = "light"
    }
    prepend variantSets = "look"
)
{
    variantSet "look" = {
        "dark" {
            over "Geometry"
            {
                over "seat"
                {
                    asset texture = @../dark.png@
                }
            }
        }
        "light" {
            over "Geometry"
            {
                over "seat"
                {
                    asset texture = @../light.png@
                }
            }
        }
    }
}
"""
EDITS = """
over "World"
{
    over "chair_1"
    {
        double3 xformOp:translate = (4, 5, 6)
    }

    def Xform "Guest" (
        references = @../../elsewhere/guest.usda@
    )
    {
    }
}
"""
GUEST = """
def Cube "Guest"
{
    asset texture = @./guest.png@
}
"""
FILES = {
    "room/layers/edits.usda": ("edits", "World", EDITS),
    "room/layers/alignment.usda": ("alignment", "World", ALIGNMENT),
    "room/layers/layout.usda": ("layout", "World", LAYOUT),
    "room/layers/alignment/chair.usda": ("chair", "Chair", CHAIR),
    "room/layers/alignment/geometry.usda": ("geometry", "Chair", GEOMETRY),
    "room/layers/materials/looks/look.usda": ("look", "Chair", LOOK),
    "elsewhere/guest.usda": ("guest", "Guest", GUEST),
}
TEXTURES = (
    "room/layers/materials/dark.png",
    "room/layers/materials/light.png",
    "elsewhere/guest.png",
)
STACK = "subLayers = [@./layers/edits.usda@, @./layers/alignment.usda@, @./layers/layout.usda@]"


def write_scene(folder: Path) -> Path:
    for name, (stage, prim, body) in FILES.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(HEADER % {"stage": stage, "prim": prim, "more": ""} + body)
    for name in TEXTURES:
        (folder / name).write_bytes(b"\x89PNG" + name.encode())
    # A file that nothing refers to stays out of the package.
    (folder / "room/layers/materials/unused.png").write_bytes(b"unused")
    scene = folder / "room/scene.usda"
    scene.write_text(HEADER % {"stage": "scene", "prim": "World", "more": STACK})
    return scene


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_scene(tmp_path)


def contents(asset: Sdf.AssetPath) -> str:
    """What an asset path leads to, wherever that lies; packages included."""
    found = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(asset.resolvedPath))
    assert found, f"{asset} leads nowhere"
    with found:
        return hashlib.sha256(found.GetBuffer()).hexdigest()


def plain(value: object) -> str:
    return contents(value) if isinstance(value, Sdf.AssetPath) else str(value)


def composed(stage: Usd.Stage) -> dict[str, object]:
    """Everything that a stage says, as plain data that does not know which layer said it."""
    everything: dict[str, object] = {}
    walk = Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies(Usd.PrimIsActive))
    for prim in walk:
        path = str(prim.GetPath())
        everything[path] = (
            prim.GetTypeName(),
            prim.GetSpecifier(),
            prim.GetAppliedSchemas(),
            prim.GetMetadata("kind"),
            prim.IsInstance(),
            {key: plain(value) for key, value in prim.GetAssetInfo().items()},
            {
                name: prim.GetVariantSets().GetVariantSelection(name)
                for name in prim.GetVariantSets().GetNames()
            },
            {
                name: prim.GetVariantSet(name).GetVariantNames()
                for name in prim.GetVariantSets().GetNames()
            },
        )
        for prop in prim.GetAuthoredProperties():
            if isinstance(prop, Usd.Relationship):
                value: object = [str(target) for target in prop.GetTargets()]
            else:
                value = plain(prop.Get())
            everything[f"{path}.{prop.GetName()}"] = (value, prop.GetCustomData())
    return everything


def assert_all_alike(scene: Path) -> None:
    flat, packed = scene.with_suffix(".usdc"), scene.with_suffix(".usdz")
    flatten(scene, flat)
    package(scene, packed, include_outside=True)
    layered = composed(Usd.Stage.Open(str(scene)))
    assert len(layered) > 10
    assert composed(Usd.Stage.Open(str(flat))) == layered
    assert composed(Usd.Stage.Open(str(packed))) == layered


def test_layered_flattened_and_packaged_are_one_scene(scene: Path) -> None:
    assert_all_alike(scene)


def test_and_so_is_a_composed_room(composed_demo: Path, tmp_path: Path) -> None:
    shutil.copytree(composed_demo.parent, tmp_path / "room")
    assert_all_alike(tmp_path / "room" / composed_demo.name)


def test_a_flattened_scene_keeps_arcs_metadata_and_records(scene: Path) -> None:
    target = scene.with_suffix(".usdc")
    flatten(scene, target)
    layer = Sdf.Layer.FindOrOpen(str(target))
    assert list(layer.subLayerPaths) == []
    stages = layer.customLayerData["openrooms"]["stages"]
    assert set(stages) == {"scene", "edits", "alignment", "layout"}
    assert layer.defaultPrim == "World"
    chair = layer.GetPrimAtPath("/World/chair_0")
    assert [ref.assetPath for ref in chair.referenceList.GetAddedOrExplicitItems()] == [
        "./layers/materials/looks/look.usda",
        "./layers/alignment/chair.usda",
    ]
    stage = Usd.Stage.Open(layer)
    record = UsdMedia.AuthorshipAPI(stage.GetPrimAtPath("/World"), "layout")
    assert record.GetSoftwareVersionAttr().Get() == "1"


def test_a_flattened_scene_can_lie_elsewhere(scene: Path, tmp_path: Path) -> None:
    target = tmp_path / "deep" / "er" / "flat.usdc"
    flatten(scene, target)
    assert composed(Usd.Stage.Open(str(target))) == composed(Usd.Stage.Open(str(scene)))
    text = Sdf.Layer.FindOrOpen(str(target)).ExportToString()
    assert "@../../room/layers/alignment/chair.usda@" in text
    assert str(tmp_path) not in text


def test_bytes_depend_on_nothing_but_the_scene(tmp_path: Path) -> None:
    first, second = write_scene(tmp_path / "a"), write_scene(tmp_path / "some" / "where")
    for path in second.parent.rglob("*"):
        os.utime(path, (1e9, 1e9))
    for path in (first, second):
        flatten(path, path.with_suffix(".usdc"))
        package(path, path.with_suffix(".usdz"), include_outside=True)
    for suffix in (".usdc", ".usdz"):
        assert first.with_suffix(suffix).read_bytes() == second.with_suffix(suffix).read_bytes()
    package(first, first.with_suffix(".usdz"), include_outside=True)
    assert first.with_suffix(".usdz").read_bytes() == second.with_suffix(".usdz").read_bytes()


def test_an_archive_keeps_the_rules_of_usdz(scene: Path) -> None:
    target = scene.with_suffix(".usdz")
    package(scene, target, include_outside=True)
    data = target.read_bytes()
    with zipfile.ZipFile(target) as archive:
        assert archive.testzip() is None
        entries = archive.infolist()
    assert entries[0].filename == "scene.usda"
    for entry in entries:
        # Read from the bytes: signature, name length and extra length of the local header.
        at = entry.header_offset
        assert data[at : at + 4] == b"PK\x03\x04"
        name, extra = struct.unpack_from("<HH", data, at + 26)
        assert (at + 30 + name + extra) % 64 == 0
        assert entry.compress_type == zipfile.ZIP_STORED
        assert entry.date_time == (1980, 1, 1, 0, 0, 0)
        assert not entry.filename.startswith("/") and ".." not in entry.filename
    assert [f for f in validate_stage(target) if f.severity == "error" and ":" in f.code] == []


def test_an_archive_holds_what_usd_would_put_into_it(scene: Path, tmp_path: Path) -> None:
    """USD's own packager is the reference: the same files, the same bytes."""
    (scene.parent / "layers/edits.usda").write_text(
        HEADER % {"stage": "edits", "prim": "World", "more": ""}
    )
    package(scene, scene.with_suffix(".usdz"), include_outside=True)
    reference = tmp_path / "reference.usdz"
    assert UsdUtils.CreateNewUsdzPackage(str(scene), str(reference))
    with zipfile.ZipFile(scene.with_suffix(".usdz")) as ours, zipfile.ZipFile(reference) as theirs:
        assert sorted(ours.namelist()) == sorted(theirs.namelist())
        assert all(ours.read(name) == theirs.read(name) for name in ours.namelist())


def test_files_from_elsewhere_move_in_and_nothing_else_is_rewritten(scene: Path) -> None:
    package(scene, scene.with_suffix(".usdz"), include_outside=True)
    with zipfile.ZipFile(scene.with_suffix(".usdz")) as archive:
        names = archive.namelist()
        assert "external/0/guest.usda" in names and "external/0/guest.png" in names
        assert "layers/materials/unused.png" not in names
        assert b"@../external/0/guest.usda@" in archive.read("layers/edits.usda")
        untouched = [n for n in names if not n.startswith("external") and "edits" not in n]
        assert all(archive.read(n) == (scene.parent / n).read_bytes() for n in untouched)


def test_absolute_paths_do_not_reach_an_archive(scene: Path) -> None:
    edits = scene.parent / "layers/edits.usda"
    elsewhere = scene.parent.parent / "elsewhere"
    edits.write_text(edits.read_text().replace("../../elsewhere", str(elsewhere)))
    package(scene, scene.with_suffix(".usdz"), include_outside=True)
    assert str(elsewhere).encode() not in scene.with_suffix(".usdz").read_bytes()


def test_a_package_can_hold_a_package(scene: Path) -> None:
    inner = scene.parent / "layers/chair.usdz"
    package(scene.parent / "layers/alignment/chair.usda", inner)
    alignment = scene.parent / "layers/alignment.usda"
    alignment.write_text(
        alignment.read_text().replace("@./alignment/chair.usda@", "@./chair.usdz@")
    )
    assert_all_alike(scene)


def break_texture(scene: Path) -> None:
    (scene.parent / "layers/materials/dark.png").unlink()


def use_a_bitmap(scene: Path) -> None:
    look = scene.parent / "layers/materials/looks/look.usda"
    look.write_text(look.read_text().replace("dark.png", "dark.bmp"))
    (scene.parent / "layers/materials/dark.bmp").write_bytes(b"BM")


def break_sublayer(scene: Path) -> None:
    (scene.parent / "layers/more.usda").symlink_to("nowhere.usda")
    spoil_edits(scene, "", "subLayers = [@./more.usda@]")


@pytest.mark.parametrize(
    ("spoil", "named"),
    [(break_texture, "dark.png"), (use_a_bitmap, "dark.bmp"), (break_sublayer, "more.usda")],
)
def test_what_cannot_be_packaged_is_named(
    spoil: Callable[[Path], None], named: str, scene: Path
) -> None:
    spoil(scene)
    with pytest.raises(StageError, match=named):
        package(scene, scene.with_suffix(".usdz"), include_outside=True)
    assert not scene.with_suffix(".usdz").exists()


@pytest.mark.parametrize("write", [flatten, package])
def test_what_cannot_be_written_leaves_nothing(
    write: Callable[[Path, Path], None], scene: Path, tmp_path: Path
) -> None:
    spoil_edits(scene, "")
    (tmp_path / "file").write_text("taken")
    with pytest.raises(OutputError):
        write(scene, tmp_path / "file" / "scene.usdz")
    with pytest.raises(InputError):
        write(tmp_path / "none.usda", tmp_path / "out.usdz")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["elsewhere", "file", "room"]


def refer(said: str) -> Callable[[Path], None]:
    """Let the edits name a picture beside the room."""

    def change(scene: Path) -> None:
        path = said.replace("ELSEWHERE", str(scene.parent.parent / "elsewhere"))
        spoil_edits(scene, f'over "World" {{\n  asset secret = @{path}@\n}}\n')

    return change


def spoil_edits(scene: Path, body: str, more: str = "") -> None:
    header = HEADER % {"stage": "edits", "prim": "World", "more": more}
    (scene.parent / "layers/edits.usda").write_text(header + body)


def link(scene: Path) -> None:
    (scene.parent / "layers/secret.png").symlink_to(scene.parent.parent / "elsewhere/guest.png")
    refer("./secret.png")(scene)


def link_folder(scene: Path) -> None:
    (scene.parent / "layers/more").symlink_to(scene.parent.parent / "elsewhere")
    refer("./more/guest.png")(scene)


def stack(scene: Path) -> None:
    spoil_edits(scene, "", "subLayers = [@../../elsewhere/guest.usda@]")


def choose_not(scene: Path) -> None:
    """A variant that nobody selects would go along all the same."""
    arc = "references = @../../elsewhere/guest.usda@"
    spoil_edits(
        scene,
        f'over "World" (variantSets = "v") {{\n  variantSet "v" = {{\n    "x" ({arc}) {{\n    }}\n'
        "  }\n}\n",
    )


OUTSIDE: dict[str, Callable[[Path], None]] = {
    "relative": refer("../../elsewhere/guest.png"),
    "absolute": refer("ELSEWHERE/guest.png"),
    "link": link,
    "linked folder": link_folder,
    "sublayer": stack,
    "variant": choose_not,
    "reference": lambda scene: None,
}


@pytest.mark.parametrize("way", OUTSIDE)
def test_files_outside_the_folder_are_named_and_not_packaged(way: str, scene: Path) -> None:
    OUTSIDE[way](scene)
    with pytest.raises(StageError, match="elsewhere/guest") as caught:
        package(scene, scene.with_suffix(".usdz"))
    assert "layers/edits.usda refers to" in str(caught.value)
    assert "--include-outside" in str(caught.value)
    assert not scene.with_suffix(".usdz").exists()
    package(scene, scene.with_suffix(".usdz"), include_outside=True)
    assert scene.with_suffix(".usdz").is_file()


def test_a_layer_from_outside_is_not_merged_into_a_flattened_scene(scene: Path) -> None:
    stack(scene)
    with pytest.raises(StageError, match="elsewhere"):
        flatten(scene, scene.with_suffix(".usdc"))
    assert not scene.with_suffix(".usdc").exists()
    flatten(scene, scene.with_suffix(".usdc"), include_outside=True)
    assert scene.with_suffix(".usdc").is_file()


def test_a_room_that_is_reached_by_a_link_lies_in_its_own_folder(scene: Path) -> None:
    spoil_edits(scene, "")
    (scene.parent.parent / "link").symlink_to(scene.parent)
    package(scene.parent.parent / "link/scene.usda", scene.with_suffix(".usdz"))


def test_a_pipe_is_not_packaged(scene: Path) -> None:
    spoil_edits(scene, "")
    texture = scene.parent / "layers/materials/dark.png"
    texture.unlink()
    os.mkfifo(texture)
    with pytest.raises(InputError, match="not a file"):
        package(scene, scene.with_suffix(".usdz"))


def test_profiles_of_lights_stay_behind(scene: Path) -> None:
    """USDZ archives hold no IES files, by the format's list of kinds."""
    stack(scene)
    (scene.parent / "layers/spot.ies").write_text("IESNA:LM-63-2002\n")
    edits = Sdf.Layer.FindOrOpen(str(scene.parent / "layers/edits.usda"))
    lamp = Sdf.CreatePrimInLayer(edits, "/World/lamp")
    lamp.specifier, lamp.typeName = Sdf.SpecifierDef, "SphereLight"
    name, kind = "inputs:shaping:ies:file", Sdf.ValueTypeNames.Asset
    Sdf.AttributeSpec(lamp, name, kind).default = Sdf.AssetPath("./spot.ies")
    edits.Save()
    target = scene.with_suffix(".usdz")
    package(scene, target, include_outside=True)
    with zipfile.ZipFile(target) as archive:
        assert not [name for name in archive.namelist() if name.endswith(".ies")]
    stage = Usd.Stage.Open(str(target))
    found = stage.GetPrimAtPath("/World/lamp").GetAttribute(name).Get()
    assert not found or not found.path
    assert not UsdUtils.ComputeAllDependencies(str(target))[2]


@pytest.mark.parametrize("target", ["edits.usda", "nowhere", "/dev/zero"])
@pytest.mark.parametrize(("write", "ending"), [(package, "usdz"), (flatten, "usdc")])
def test_a_layer_that_is_a_broken_link_is_refused_at_most(
    write: Callable[[Path, Path], object],
    ending: str,
    target: str,
    composed_demo: Path,
    tmp_path: Path,
) -> None:
    shutil.copytree(composed_demo.parent, tmp_path / "room")
    edits = tmp_path / "room/layers/edits.usda"
    edits.unlink()
    edits.symlink_to(target)
    made = tmp_path / f"made.{ending}"
    try:
        with quiet():
            write(tmp_path / "room/scene.usda", made)
    except OrusdError as error:
        assert "edits" in str(error)
        assert not made.exists()
