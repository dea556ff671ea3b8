"""Every command that writes where a person says: what lies there gives way only if it is ours.

A new command without a case fails, since the commands are asked for what they take.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import click
import pytest

from openrooms_usd.cli import orusd
from openrooms_usd.errors import OrusdError
from tests.appearance.photographed import one_grey
from tests.commands import output_of, run
from tests.comparison.test_compare import write_room
from tests.conftest import SMALL_ROOM
from tests.openrooms.synthetic import make_render

STAGE = """\
#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    kilogramsPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def PhysicsScene "Scene" {}
    def Cube "crate" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]
    )
    {
        double size = 0.2
        float physics:mass = 1
    }
    def Mesh "floor"
    {
        point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        uniform token subdivisionScheme = "none"
    }
    def SphereLight "Lamp"
    {
        float inputs:intensity = 1000
        double3 xformOp:translate = (0, 0, 2)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Camera "View"
    {
        double3 xformOp:translate = (0, 0, 3)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""
DATASET = """\
name: small
rooms: [{files: [room.yaml]}]
views: {count: 1, resolution: [24, 18]}
channels: [radiance, depth, instance, valid]
budget: {samples: 1}
rendering: {renderer: preview}
"""
BARE_ROOM = SMALL_ROOM.partition("furniture:")[0]

# What a command takes that names something to write.
WRITING = {"out", "export", "report_file", "root", "folder"}
READING = {"dataset status", "dataset verify", "dataset stats", "edit fix-units", "edit orphans"}
# Lists of all scenes, and a lens that stays where another one is there.
OPENROOMS = ("train.txt", "val.txt", "test.txt", "scenes/intrinsic.txt")
QUICK = "--variant scalar --spp 1 --resolution 8x8"


@dataclass(frozen=True)
class Case:
    """A command that writes to ``HERE``, of what lies in ``STOCK``.

    Attributes:
        words: Of the command.
        others: Where files begin that are shared with others, or records of ours.
        before: What has to be run before.
        resumes: Whether it leaves alone what it has done, and goes on beside it.
        slow: Whether it takes seconds.
    """

    words: str
    before: str = ""
    others: tuple[str, ...] = ()
    resumes: bool = False
    slow: bool = False


CASES = {
    "convert mitsuba": Case("convert STOCK/stage.usda HERE/a.xml"),
    "convert folder": Case("convert STOCK/stage.usda HERE --format mitsuba"),
    "convert gltf": Case("convert STOCK/stage.usda HERE/a.glb"),
    "convert usdz": Case("convert STOCK/stage.usda HERE/a.usdz"),
    "convert arkit": Case("convert STOCK/stage.usda HERE/a.usdz --profile arkit", slow=True),
    "convert urdf": Case("convert STOCK/stage.usda HERE --format urdf"),
    "convert mjcf": Case("convert STOCK/stage.usda HERE --format mjcf"),
    "convert usdphysics": Case("convert STOCK/stage.usda HERE --format usdphysics"),
    "convert openrooms-xml": Case(
        "convert STOCK/room/scene.usda HERE --format openrooms-xml", slow=True
    ),
    "convert --report": Case("convert STOCK/stage.usda STOCK/b.glb --report HERE/report.json"),
    "render": Case(f"render STOCK/stage.usda -o HERE {QUICK} --channels depth"),
    "render --path": Case(
        f"render STOCK/room/scene.usda -o HERE {QUICK} --path walk --duration 0.1 --keep-frames",
        slow=True,
    ),
    "render --report": Case(
        f"render STOCK/stage.usda -o STOCK/out {QUICK} --channels depth --report HERE/report.json"
    ),
    "render --dataset": Case(
        f"render STOCK/stage.usda -o STOCK/out {QUICK} --dataset HERE", others=OPENROOMS, slow=True
    ),
    "bake": Case("bake STOCK/stage.usda -o HERE --spp 1 --texel 0.1", slow=True),
    "probe": Case("probe STOCK/stage.usda -o HERE --at 0,0,1 --spp 1 --resolution 8x8", slow=True),
    "compare": Case("compare STOCK/taken/out/scene.usda -o HERE --renderer preview --width 24"),
    "appearance": Case(
        "appearance STOCK/seen/room.usda --photographs STOCK/seen/frames.json -o HERE/a.usda",
        slow=True,
    ),
    "relight": Case(
        "relight STOCK/lit -o HERE",
        before="render STOCK/stage.usda -o STOCK/lit --spp 1 --resolution 8x8"
        " --channels radiance_i",
        slow=True,
    ),
    "labels": Case("labels STOCK/plain -o HERE/labels.json"),
    "compose": Case("compose STOCK/bare.yaml -o HERE --only layout", others=("layers/layout/",)),
    "compose all": Case(
        "compose STOCK/bare.yaml -o HERE --flatten --usdz", resumes=True, slow=True
    ),
    "demo": Case("demo -o HERE --spp 1", resumes=True, slow=True),
    "init": Case("init HERE"),
    "generate": Case("generate --type hallway --clutter 0 -o HERE", slow=True),
    "generate --count": Case("generate --type hallway --clutter 0 --count 2 -o HERE", slow=True),
    "import": Case("import boxes STOCK/taken/boxes.json -o HERE"),
    "simulate": Case("simulate STOCK/stage.usda -o HERE/settled.usda --duration 0.01"),
    "view": Case("view STOCK/stage.usda --export HERE/page.html"),
    "edit layout": Case("edit layout STOCK/bare.yaml --export HERE/page.html"),
    "edit materials": Case(
        "edit materials STOCK/room/scene.usda --export HERE/page.html", slow=True
    ),
    "edit objects": Case("edit objects STOCK/room/scene.usda --export HERE/page.html", slow=True),
    "dataset plan": Case("dataset plan STOCK/dataset.yaml -o HERE/plan.jsonl"),
    "dataset run": Case(
        "dataset run STOCK/dataset.yaml -o HERE",
        others=("records/", "timing/", "failures/"),
        resumes=True,
        slow=True,
    ),
    "dataset report": Case(
        "dataset report STOCK/data -o HERE/report.html",
        before="dataset run STOCK/dataset.yaml -o STOCK/data",
        slow=True,
    ),
    "dataset write openrooms": Case("dataset write STOCK/render -o HERE", others=OPENROOMS),
    "dataset write nerf": Case("dataset write STOCK/render -o HERE --format nerf"),
    "dataset write coco": Case("dataset write STOCK/plain -o HERE --format coco"),
    "dataset write webdataset": Case("dataset write STOCK/render -o HERE --format webdataset"),
    "dataset write hypersim": Case("dataset write STOCK/render -o HERE --format hypersim"),
    "library sheet": Case(
        "library sheet -o HERE/sheet.png --category stool --size 16 --renderer preview", slow=True
    ),
    "materials sheet": Case(
        "materials sheet -o HERE --substance paint --size 16 --spp 1 --variant scalar", slow=True
    ),
}


def commands(group: click.Group, above: str = "") -> Iterator[tuple[str, click.Command]]:
    """All commands below a group; one of import stands for all, which share their code."""
    with click.Context(group) as context:
        for name in group.list_commands(context):
            command = group.get_command(context, name)
            if name == "import":
                yield name, command.get_command(context, "boxes")
            elif isinstance(command, click.Group):
                yield from commands(command, f"{name} ")
            else:
                yield f"{above}{name}", command


def test_every_command_that_writes_has_a_case() -> None:
    missing = []
    for name, command in commands(orusd):
        for one in command.params:
            if one.name in WRITING and name not in READING:
                flag = max(
                    (word for word in one.opts if word.startswith("--")), default="", key=len
                )
                known = [case.words for case in CASES.values() if case.words.startswith(f"{name} ")]
                if not any(flag in ("", "--out") or flag in words for words in known):
                    missing.append(f"{name} {flag}")
    assert missing == []


@pytest.fixture(scope="module")
def stock(tmp_path_factory: pytest.TempPathFactory, composed_demo: Path) -> Path:
    """What all commands read."""
    folder = tmp_path_factory.mktemp("stock")
    (folder / "stage.usda").write_text(STAGE)
    (folder / "bare.yaml").write_text(BARE_ROOM)
    (folder / "room.yaml").write_text(SMALL_ROOM)
    (folder / "dataset.yaml").write_text(DATASET)
    (folder / "room").symlink_to(composed_demo.parent)
    (folder / "taken").mkdir()
    write_room(folder / "taken")
    make_render(folder / "render")
    (folder / "seen").mkdir()
    one_grey(folder / "seen")
    labelled = f"render STOCK/stage.usda -o STOCK/plain --channels instance,semantic {QUICK}"
    output_of(*words(labelled, folder))
    return folder


def words(text: str, stock: Path, here: Path | None = None) -> list[str]:
    return text.replace("STOCK", str(stock)).replace("HERE", str(here)).split()


def contents(folder: Path) -> dict[str, bytes]:
    """The files of a folder but those that we keep for ourselves."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    named = {path.relative_to(folder): path for path in paths}
    return {
        str(name): path.read_bytes()
        for name, path in named.items()
        if not any(part.startswith(".orusd.") for part in name.parts)
    }


def refused(case: Case, stock: Path, here: Path, name: str) -> None:
    """The file stays; the command fails with one message, which says where, and changes nothing."""
    before = contents(here)
    result = run(*words(case.words, stock, here))
    if case.resumes:
        assert (here / name).read_bytes() == before[name], name
        return
    assert contents(here) == before, name
    assert isinstance(result.exception, OrusdError), (name, result.output, result.exception)
    assert result.exception.place


def depth(name: str) -> tuple[int, str]:
    return name.count("/"), name


def of_each_kind(names: list[str]) -> list[str]:
    """One of those that lie in one folder and end alike."""
    return list({(Path(name).parts[:2][:-1], Path(name).suffix): name for name in names}.values())


def check(case: Case, stock: Path, tmp_path: Path, tried: Callable[[list[str]], list[str]]) -> None:
    if case.before:
        output_of(*words(case.before, stock))
    here = tmp_path / "here"
    here.mkdir()
    output_of(*words(case.words, stock, here))
    written = contents(here)
    output_of(*words(case.words, stock, here))
    assert contents(here).keys() == written.keys()
    names = sorted((name for name in written if not name.startswith(case.others)), key=depth)
    # Times belong to who the manifest belongs to.
    noted = [name for name in names if not name.endswith("timing.json")]
    for name in tried(noted):
        ours = (here / name).read_bytes()
        (here / name).write_bytes(b"changed by hand")
        refused(case, stock, here, name)
        (here / name).write_bytes(ours)
    for name in tried(names[::-1]):
        other = tmp_path / name.replace("/", "_")
        (other / name).parent.mkdir(parents=True)
        (other / name).write_bytes(b"a stranger's")
        refused(case, stock, other, name)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", [name for name, case in CASES.items() if not case.slow])
def test_only_what_is_ours_and_unchanged_gives_way(name: str, stock: Path, tmp_path: Path) -> None:
    check(CASES[name], stock, tmp_path, lambda names: names[:1])


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", [name for name, case in CASES.items() if not case.slow])
def test_they_are_quiet_or_print_json_alone(name: str, stock: Path, tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    command = words(CASES[name].words, stock, tmp_path / "here")
    # Warnings are said all the same.
    said = output_of(*command, "--quiet").splitlines()
    assert [line for line in said if not line.startswith("warning: ")] == []
    done = run(*command, "--json")
    assert done.exit_code == 0 and isinstance(json.loads(done.stdout), dict)
    shown = run(*command, "--verbose")
    assert shown.stdout and (" s  " in shown.stderr or name in ("init", "dataset plan"))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, case in CASES.items() if not case.slow])
def test_so_does_each_kind_of_file(name: str, stock: Path, tmp_path: Path) -> None:
    check(CASES[name], stock, tmp_path, of_each_kind)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_so_does_every_file(name: str, stock: Path, tmp_path: Path) -> None:
    check(CASES[name], stock, tmp_path, lambda names: names)
