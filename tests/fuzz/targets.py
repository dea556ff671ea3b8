"""Names on the command line that are none: pipes, devices, links in circles, names too long."""

from pathlib import Path

from tests.fuzz.kinds import Kind
from tests.fuzz.renders import plant_finished
from tests.fuzz.spoiling import BESIDE

_BOXES = "id,label,x,y,z,width,depth,height,yaw\na,chair,1,2,0,0.5,0.6,0.9,30\n"
_ROOM = "name: t\nroom: office\nmaterials: {resolution: 16}\n"

_COMMANDS = (
    "import boxes {in}/boxes.csv -o",
    "compose {in}/room.yaml -o",
    "render {in}/scene.usda --renderer fake --spp 1 --channels radiance -o",
    "convert {in}/scene.usda --format usdphysics",
    "labels {in}/render -o",
    "relight {in}/render/view_0 --light lamp=2 -o",
    "dataset write {in}/render -o",
    "generate --type office -o",
)
# What lies beside every case, and what cannot.
_TARGETS = ("pipe", "circle", "endless", "keep.txt/x", "pipe/x", "circle/x", "x" * 300, "x/" * 2100)

# What reads a file or folder; the asterisk stands for its name without ending.
_READERS = (
    "import roomplan *.json -o {out}",
    "import roomplan *.usdz -o {out}",
    "import scan2cad *.json -o {out} --polygon *.csv",
    "import boxes *.csv -o {out}",
    "import scannet * -o {out}",
    "import sunrgbd * -o {out}",
    "import sunrgbd *.pkl -o {out}",
    "import arkitscenes * -o {out}",
    *(f"import scan *.{end} -o {{out}}" for end in ("ply", "pcd", "xyz", "npz", "glb", "e57")),
    "compose *.yaml -o {out}",
    "validate *.usda",
    "validate *.usdz",
    "edit orphans *",
    "edit fix-units *",
    "edit import-changes */scene.usda",
    "edit import-changes {in}/scene.usda --from *.usdc",
    "annotate * -o {out}",
    "relight * -o {out} --light lamp=1",
    "dataset write * -o {out}",
    "convert *.usda {out}",
    "dataset plan *.yaml",
    "dataset run *.yaml -o {out}",
    "dataset status *",
    "dataset verify *",
    "dataset stats *",
    "render *.usda -o {out} --renderer fake",
    "simulate *.usda",
)
_SOURCES = ("{in}/" + "x" * 300, "{in}/" + "x/" * 2100, "{in}/../beside/circle/x", "{in}/none")


def _plant(folder: Path) -> None:
    plant_finished(folder)
    inner = folder / "in"
    (inner / "boxes.csv").write_text(_BOXES)
    (inner / "room.yaml").write_text(_ROOM)


KINDS = (
    Kind(
        "targets",
        _plant,
        tuple(
            (1, f"{command} {{in}}/../{BESIDE}/{target}")
            for command in _COMMANDS
            for target in _TARGETS
        ),
        ("in/boxes.csv", "in/room.yaml", "in/scene.usda", "in/render/manifest.json"),
        hostile=True,
    ),
    Kind(
        "sources",
        _plant,
        tuple((1, reader.replace("*", source)) for reader in _READERS for source in _SOURCES),
        ("in/scene.usda",),
        hostile=True,
        share=1,
    ),
)
