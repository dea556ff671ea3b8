"""What is in the wheel, and what is not."""

import configparser
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = {
    "openrooms_usd",
    "orusd_schemas",
    "orusd_gltf",
    "orusd_mitsuba",
    "orusd_nerf",
    "orusd_openrooms",
    "orusd_preview",
    "orusd_scans",
    "orusd_urdf",
    "orusd_usdz",
    "orusd_hypersim",
    "orusd_webdataset",
}
DATA = {
    "openrooms_usd/py.typed",
    "openrooms_usd/demo/room.yaml",
    "openrooms_usd/library/surroundings/hosek_wilkie.npy",
    "openrooms_usd/library/surroundings/hosek_wilkie.LICENSE.txt",
    "openrooms_usd/usd/mapping.toml",
    "orusd_gltf/py.typed",
    "orusd_hypersim/py.typed",
    "orusd_webdataset/py.typed",
    "orusd_mitsuba/py.typed",
    "orusd_nerf/py.typed",
    "orusd_openrooms/py.typed",
    "orusd_preview/py.typed",
    "orusd_scans/py.typed",
    "orusd_urdf/py.typed",
    "orusd_usdz/py.typed",
    "orusd_schemas/py.typed",
    "orusd_schemas/generatedSchema.usda",
    "orusd_schemas/plugInfo.json",
    "orusd_schemas/dataset.schema.json",
    "orusd_schemas/room.schema.json",
    "orusd_schemas/schema.usda",
}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(out)]
    done = subprocess.run([*command, str(ROOT)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (path,) = out.glob("*.whl")
    return zipfile.ZipFile(path)


def test_a_wheel_has_exactly_our_packages(wheel: zipfile.ZipFile) -> None:
    tops = {name.split("/")[0] for name in wheel.namelist()}
    (info,) = (top for top in tops if top.endswith(".dist-info"))
    assert tops - {info} == PACKAGES
    assert f"{info}/licenses/LICENSE" in wheel.namelist()


def test_a_wheel_has_the_data_files(wheel: zipfile.ZipFile) -> None:
    assert set(wheel.namelist()) >= DATA


def test_a_wheel_has_every_source_file_and_nothing_that_is_made(wheel: zipfile.ZipFile) -> None:
    sources = (ROOT / "openrooms_usd", ROOT / "schemas", ROOT / "converters")
    modules = {path.name for source in sources for path in source.rglob("*.py")}
    assert {Path(name).name for name in wheel.namelist() if name.endswith(".py")} == modules
    assert not [name for name in wheel.namelist() if "__pycache__" in name]


def test_a_wheel_registers_the_command_and_the_adapters(wheel: zipfile.ZipFile) -> None:
    (name,) = (n for n in wheel.namelist() if n.endswith("entry_points.txt"))
    points = configparser.ConfigParser()
    points.read_string(wheel.read(name).decode())
    assert dict(points["console_scripts"]) == {"orusd": "openrooms_usd.cli:main"}
    kinds = {
        "importers",
        "renderers",
        "exporters",
        "datasets",
        "engines",
        "executors",
        "segmenters",
        "sources",
        "photographs",
    }
    assert kinds == {
        section.removeprefix("openrooms_usd.") for section in points if "openrooms_usd" in section
    }


def test_the_lists_of_packages_in_pyproject_agree() -> None:
    tool = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]
    built = {Path(path).name for path in tool["hatch"]["build"]["targets"]["wheel"]["packages"]}
    converters = {path.name for path in (ROOT / "converters").glob("orusd_*")}
    assert built == PACKAGES == set(tool["mypy"]["packages"])
    assert converters == PACKAGES - {"openrooms_usd", "orusd_schemas"}
