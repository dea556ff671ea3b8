"""Other code writes other layers and files, and nobody's edits are lost over it."""

import functools
import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from pxr import Sdf, Usd

from openrooms_usd import codedigest, names
from openrooms_usd.codedigest import modules
from openrooms_usd.composing import compose_room
from openrooms_usd.description.room import Room
from openrooms_usd.furniture import CATEGORIES, module_of
from openrooms_usd.geometry.solids import rounded_box
from openrooms_usd.library.textures import Material
from openrooms_usd.physics.components import Part
from openrooms_usd.steps import base, runner
from openrooms_usd.steps.alignment.catalogue import Catalogue
from openrooms_usd.steps.materials.palette import Swatch
from openrooms_usd.steps.physics import cache as physics_cache
from openrooms_usd.steps.physics import step as physics

ROOT = Path(__file__).parents[2]
ALL = set(names.STEPS)

Plant = Callable[..., None]


def forget() -> None:
    for known in vars(codedigest).values():
        if hasattr(known, "cache_clear"):
            known.cache_clear()


@pytest.fixture
def plant(monkeypatch: pytest.MonkeyPatch) -> Iterator[Plant]:
    """Adds something to what is read of a file of the project: by default what counts."""

    read = codedigest._read

    def plant(path: str, more: bytes = b"\nPLANTED = 1\n") -> None:
        before = read(path)
        assert before is not None

        def planted(asked: str) -> bytes | None:
            return before + more if asked == path else read(asked)

        monkeypatch.setattr(codedigest, "_read", planted)
        forget()

    forget()
    yield plant
    monkeypatch.undo()
    forget()


def fingerprints(room: Room, folder: Path) -> dict[str, str]:
    return {
        step.name: base.fingerprint(step, room, folder, lambda name: folder / name)
        for step in runner.steps()
    }


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("file", "changed"),
    [
        ("openrooms_usd/steps/runner.py", ALL),
        ("openrooms_usd/usd/files/layers.py", ALL),
        ("openrooms_usd/draws.py", ALL),
        ("openrooms_usd/library/textures/rough_stone/masonry.py", {"materials", "physics"}),
        ("openrooms_usd/library/textures/base/noise.py", {"materials", "physics"}),
        ("openrooms_usd/library/friction/table.npy", {"materials", "physics"}),
        ("openrooms_usd/library/surroundings/hosek_wilkie.npy", {"lights"}),
        ("openrooms_usd/library/surroundings/sunlight.py", {"lights"}),
        ("openrooms_usd/physics/merging.py", {"physics"}),
        ("openrooms_usd/furniture/categories/sofa.py", set()),
        ("openrooms_usd/description/categories.py", set()),
        ("openrooms_usd/rendering/exr.py", set()),
        ("openrooms_usd/cli/composing.py", set()),
        ("openrooms_usd/generation/__init__.py", set()),
    ],
)
def test_a_changed_file_changes_the_fingerprints_of_those_that_use_it(
    plant: Plant, tmp_path: Path, file: str, changed: set[str]
) -> None:
    before = fingerprints(Room(), tmp_path)
    plant(file)
    after = fingerprints(Room(), tmp_path)
    assert {name for name in ALL if before[name] != after[name]} == changed


def test_an_importer_counts_where_a_section_is_read_by_it(plant: Plant, tmp_path: Path) -> None:
    (tmp_path / "room.json").write_text("{}")
    captured = Room.model_validate({"layout": {"from": "roomplan", "file": "room.json"}})
    before = fingerprints(captured, tmp_path), fingerprints(Room(), tmp_path)
    plant("orusd_scans/roomplan/importer.py")
    assert fingerprints(captured, tmp_path)["layout"] != before[0]["layout"]
    assert fingerprints(Room(), tmp_path) == before[1]


def written(room: Room, out: Path) -> set[str]:
    done = compose_room(room, out, workers=2)
    return {row.stage for row in done.stages if row.state == "written"}


def furnished(*categories: str) -> Room:
    things = [{"category": name, "at": [1 + i, 1]} for i, name in enumerate(categories)]
    return Room.model_validate(
        {"furniture": {"objects": things}, "materials": {"resolution": 16}, "physics": {}}
    )


def test_steps_run_again_when_code_that_they_used_is_another(plant: Plant, tmp_path: Path) -> None:
    """Comments and docstrings are no code, and a category counts where somebody asked for it."""
    toasts, sits = tmp_path / "toasts", tmp_path / "sits"
    rooms = {toasts: furnished("toaster"), sits: furnished("chair")}

    def each_written() -> list[set[str]]:
        return [written(room, out) for out, room in rooms.items()]

    toaster = "openrooms_usd/furniture/categories/toaster.py"
    of_toasters = ALL - {"layout"}
    assert each_written() == [ALL, ALL]
    assert each_written() == [set(), set()]
    plant(toaster, b"# A comment.\n")
    assert each_written() == [set(), set()]
    plant("openrooms_usd/steps/runner.py", b"'A text that stands alone.'\n# A comment.\n")
    assert each_written() == [set(), set()]
    plant("openrooms_usd/description/categories.py")
    assert each_written() == [set(), set()]
    plant(toaster)
    assert each_written() == [of_toasters, set()]
    assert each_written() == [set(), set()]
    # The names of assets hang on the code, and so does every layer that has them.
    plant("openrooms_usd/steps/runner.py")
    assert each_written() == [ALL, ALL]


def test_other_rooms_before_it_do_not_change_what_a_room_asks_for(tmp_path: Path) -> None:
    """What a process has already worked out counts for everyone who uses it."""
    alone, second = tmp_path / "alone", tmp_path / "second"
    rooms = [furnished("toaster"), furnished("chair", "toaster")]
    for out, room in zip((alone, tmp_path / "other", second), (*rooms, rooms[0]), strict=True):
        compose_room(room, out, workers=2)
    for name in names.STEPS:
        layers = [(out / f"layers/{name}.usda").read_bytes() for out in (alone, second)]
        assert layers[0] == layers[1], name


def test_words_that_are_no_modules_are_not_read_from_a_layer() -> None:
    before = base.completed("a", ["openrooms_usd.furniture.categories.chair"])
    odd = ["os", "openrooms_usd/../secret", "openrooms_usd..x", "*"]
    assert base.completed("a", odd) == base.completed("a", [])
    assert base.completed("a", [*odd, "openrooms_usd.furniture.categories.chair"]) == before
    assert base.completed("a", []) != before


def asset_names(folder: Path) -> dict[str, str]:
    context = base.StepContext(Room(), folder, Usd.Stage.CreateInMemory(), folder)
    catalogue = Catalogue(context)
    return {name: catalogue.furniture(name, CATEGORIES[name].size).name for name in CATEGORIES}


@pytest.mark.parametrize(
    ("file", "changed"),
    [
        ("openrooms_usd/furniture/categories/bathtub.py", {"bathtub"}),
        ("openrooms_usd/furniture/joinery/pieces.py", set(CATEGORIES)),
        ("openrooms_usd/library/assets.py", set(CATEGORIES)),
        ("openrooms_usd/draws.py", set(CATEGORIES)),
        ("openrooms_usd/library/textures/rough_stone/masonry.py", set()),
        ("openrooms_usd/steps/layout/step.py", set()),
    ],
)
def test_assets_are_named_by_the_code_of_their_category(
    plant: Plant, tmp_path: Path, file: str, changed: set[str]
) -> None:
    before = asset_names(tmp_path)
    plant(file)
    after = asset_names(tmp_path)
    assert {name for name in before if before[name] != after[name]} == changed


def test_bodies_are_named_by_the_record_of_their_category(plant: Plant) -> None:
    def codes() -> list[str]:
        return [physics._code(category) for category in ("toaster", "Toaster_2", "sofa", "a thing")]

    before = codes()
    plant("openrooms_usd/furniture/categories/toaster.py")
    assert [a == b for a, b in zip(before, codes(), strict=True)] == [False, False, True, True]


def test_categories_are_built_by_the_modules_that_are_named() -> None:
    for name, spec in CATEGORIES.items():
        used = modules(module_of(name))
        assert sys.modules[module_of(name)].CATEGORY is spec
        for style in spec.styles.values():
            build = style.build
            made = build.func if isinstance(build, functools.partial) else build
            assert made.__module__ in used, name


def test_textures_are_named_by_the_code_of_their_substance(plant: Plant) -> None:
    def digests() -> dict[str, str]:
        return {name: Material(name, 0).digest for name in ("denim", "agate", "birch_plywood")}

    before = digests()
    plant("openrooms_usd/library/textures/fabric/weave.py")
    after = digests()
    assert [name for name in before if before[name] != after[name]] == ["denim"]


def test_shapes_of_other_code_and_of_other_libraries_are_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, plant: Plant
) -> None:
    monkeypatch.setenv("ORUSD_CACHE", str(tmp_path))
    mesh = rounded_box((1.0, 0.5, 0.3), 0.0)
    corners, _ = mesh.triangles()
    part = Part("part", mesh.points, mesh.indices[corners])

    def entries() -> int:
        physics_cache.cached_shapes([part], "hull", 0.01)
        return len(list((tmp_path / "shapes").iterdir()))

    assert (entries(), entries()) == (1, 1)
    plant("openrooms_usd/library/textures/fabric/weave.py")
    assert entries() == 1
    plant("openrooms_usd/geometry/triangulation.py")
    assert entries() == 2
    monkeypatch.setattr(physics_cache, "library_versions", lambda *_, leaves=(): ("scipy 0",))
    assert entries() == 3


def test_swatches_are_named_by_what_is_said_of_them() -> None:
    plain = Swatch("wood", "birch_plywood", 3)
    assert Swatch("wood", "birch_plywood", 3, color=None, wear=1.0).digest == plain.digest
    others = {"number": 4, "color": (0.1, 0.2, 0.3), "across": True, "size": 0.5, "wear": 0.9}
    found = {replace(plain, **{name: value}).digest for name, value in others.items()}
    assert len(found | {plain.digest}) == len(others) + 1


# Other names would part people's edits from what they edit.
@pytest.mark.parametrize(
    ("swatch", "said"),
    [
        (
            Swatch("wood", "birch_plywood", 3),
            '{"family": "birch_plywood", "number": 3, "substance": "wood"}',
        ),
        (
            Swatch("metal", title="steel", color=(0.5, 0.25, 1.0), metallic=1.0),
            '{"color": [0.5, 0.25, 1.0], "metallic": 1.0, "substance": "metal", "title": "steel"}',
        ),
    ],
)
def test_the_names_of_materials_stay(swatch: Swatch, said: str) -> None:
    assert swatch.digest == hashlib.sha256(said.encode()).hexdigest()[:8]


DESCRIPTION = """
room: living_room
seed: 4
furniture:
  objects:
    - {name: sofa, category: sofa, at: [2, 3.4]}
    - {name: chair, category: chair, at: [1, 1], style: slat}
materials: {resolution: 16}
"""
COMPOSE = """
import sys
from pathlib import Path
import openrooms_usd
from openrooms_usd.composing import compose_room
assert Path(openrooms_usd.__file__).is_relative_to(sys.argv[1]), openrooms_usd.__file__
done = compose_room(Path(sys.argv[2]), Path(sys.argv[3]), workers=1)
print(*(row.stage for row in done.stages if row.state == "written"))
"""
# Chairs lose a part.
CHANGE = """

def _without(build):
    def make(size, rng):
        parts = dict(build(size, rng))
        del parts["seat"]
        return parts
    return make

from dataclasses import replace as _replace
CATEGORY = _replace(CATEGORY, styles={
    name: _replace(style, build=_without(style.build))
    for name, style in CATEGORY.styles.items()
})
"""


def python(script: str, *arguments: object, **environment: object) -> str:
    command = [sys.executable, "-P", "-c", script, *map(str, arguments)]
    known = {**os.environ, **{name: str(value) for name, value in environment.items()}}
    done = subprocess.run(command, env=known, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def run(code: Path, folder: Path) -> list[str]:
    room, out, cache = folder / "room.yaml", folder / "out", folder / "cache"
    return python(COMPOSE, code, room, out, PYTHONPATH=code, ORUSD_CACHE=cache).split()


def prims(stage: Usd.Stage) -> set[str]:
    found = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
    return {str(prim.GetPath()) for prim in found}


@pytest.mark.slow
def test_edits_stay_and_meshes_change_when_a_builder_is_rewritten(tmp_path: Path) -> None:
    code = tmp_path / "code"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "openrooms_usd", code / "openrooms_usd", ignore=ignored)
    (tmp_path / "room.yaml").write_text(DESCRIPTION)
    assert run(code, tmp_path) == list(names.STEPS)
    assert run(code, tmp_path) == []
    scene = str(tmp_path / "out" / names.SCENE)
    before = prims(Usd.Stage.Open(scene))
    old = {path.name for path in (tmp_path / "out/layers/alignment/assets").iterdir()}
    [wall, *_] = sorted(path for path in before if path.startswith(f"{names.MATERIALS}/"))
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "out/layers/edits.usda"))
    for path in (f"{names.FURNITURE}/chair", wall):
        spec = Sdf.CreatePrimInLayer(layer, path)
        Sdf.AttributeSpec(spec, "byHand", Sdf.ValueTypeNames.Int).default = 7
    layer.Save()
    run(code, tmp_path)

    chair = code / "openrooms_usd/furniture/categories/chair.py"
    chair.write_text(chair.read_text() + CHANGE)
    # A material's textures are made by these, its name is not.
    for name in ("library/textures/base/recipe.py", "steps/runner.py"):
        file = code / "openrooms_usd" / name
        file.write_text(file.read_text() + "# more\n")
    # All that stand on the furniture; a comment changes nothing.
    assert run(code, tmp_path) == list(names.STEPS)[1:]
    stage = Usd.Stage.Open(scene)
    stage.Reload()
    gone = before - prims(stage)
    assert gone and all(path.startswith(f"{names.FURNITURE}/chair/") for path in gone)
    assert f"{names.FURNITURE}/chair/Geometry/seat" in gone
    for path in (f"{names.FURNITURE}/chair", wall):
        prim = stage.GetPrimAtPath(path)
        assert prim.IsDefined(), path
        assert prim.GetAttribute("byHand").Get() == 7
    new = {path.name for path in (tmp_path / "out/layers/alignment/assets").iterdir()}
    assert {name.rpartition("_")[0] for name in old - new} == {"chair"}
    assert {name for name in new if name.startswith("sofa")} == {
        name for name in old if name.startswith("sofa")
    }


# Says of every step which functions of the project ran while it wrote its layer.
TRACE = """
import json, sys, threading
from pathlib import Path
from openrooms_usd.composing import compose_room
from openrooms_usd.steps import runner
home = Path(sys.argv[3])
ours = str(home / 'openrooms_usd')
ran = {}
def watched(step):
    author, files = step.author, ran.setdefault(step.name, set())
    def note(frame, event, argument):
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(ours) and code.co_name != "<module>":
            files.add(code.co_filename)
    def traced(context):
        threading.setprofile(note)
        sys.setprofile(note)
        author(context)
        sys.setprofile(None)
        threading.setprofile(None)
    step.author = traced
    return step
made = runner.steps
runner.steps = lambda: [watched(step) for step in made()]
compose_room(Path(sys.argv[1]), Path(sys.argv[2]), workers=2)
print(json.dumps({name: sorted(
    ".".join(Path(file).relative_to(home).with_suffix("").parts).removesuffix(".__init__")
    for file in files
) for name, files in ran.items()}))
"""
RICH = """
room: bedroom
layout:
  openings: [{kind: window, wall: 0}, {kind: door, wall: 1}]
furniture:
  objects:
    - {category: dresser, name: dresser, at: [1, 1]}
    - {category: table_lamp, on: dresser, at: [1, 1]}
materials: {resolution: 16, looks: 2, floor: running_bond_brick}
lights: {environment: {latitude: 48, longitude: 11, date: 2026-06-21, time: "12:00"}}
cameras: {resolution: [32, 24], views: [{eye: [3, 3, 1.5], target: [1, 1, 1]}]}
physics: {shapes: hull}
"""


@pytest.mark.slow
def test_what_runs_in_a_step_is_in_its_graph(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(RICH)
    out = tmp_path / "out"
    ran = json.loads(python(TRACE, tmp_path / "room.yaml", out, ROOT, ORUSD_CACHE="off"))
    assert set(ran) == ALL
    for step in runner.steps():
        layer = Sdf.Layer.FindOrOpen(str(out / f"layers/{step.name}.usda"))
        known = set(modules(*base.code_of(step), *base.record_of(layer, step.name)["counted"]))
        assert len(ran[step.name]) >= 5, step.name
        assert set(ran[step.name]) <= known, step.name
    assert "openrooms_usd.library.surroundings.sky" in ran["lights"]
    assert "openrooms_usd.physics.decomposition" in ran["physics"]


def test_no_step_imports_modules_by_names_that_it_works_out() -> None:
    known = {
        # The public names of the package, which nothing inside it uses.
        "openrooms_usd",
        # The steps themselves: each is the root of its own digest.
        "openrooms_usd.steps.runner",
        # The records of categories, which say that they were asked for.
        "openrooms_usd.furniture.registry",
    }
    for step in runner.steps():
        for name in modules(*base.code_of(step)):
            source = (codedigest._read(codedigest._path(name) or "") or b"").decode()
            works_out = "import_module(" in source or "__import__(" in source
            assert not works_out or name in known, f"{step.name}: {name}"


def test_the_public_names_of_the_package_are_not_used_inside() -> None:
    import openrooms_usd

    homes = {f"openrooms_usd.{name}" for name in openrooms_usd._HOME}
    for step in runner.steps():
        for name in modules(*base.code_of(step)):
            module = codedigest._module(name)
            assert module is not None
            source = (codedigest._read(codedigest._path(name) or "") or b"").decode()
            used = {line for line in source.splitlines() if line.startswith("from openrooms_usd ")}
            for public in homes:
                word = public.rpartition(".")[2]
                assert not any(word in line.split("import")[1] for line in used), name
