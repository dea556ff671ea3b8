"""What a dataset's sensor writes lies beside the truth, which stays as it is without one."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from openrooms_usd.dataset.run import run_dataset

SENSOR = """\
sensor:
  distortion: {k1: -0.1}
  noise: {iso: 800}
  depth: {}
  seed: 1
"""
NAMES = {"sensor.exr", "sensor.png", "sensor_depth.exr", "sensor_depth.png"}


@pytest.mark.slow
def test_no_file_of_the_truth_changes_by_a_bit(
    tmp_path: Path,
    write_source: Callable[[Path], Path],
    checksums: Callable[[Path], dict[str, str]],
) -> None:
    file = write_source(tmp_path / "source")
    text = (
        file.read_text()
        .replace(", poisoned/room.yaml", "")
        .replace("[main, mainDiffMat]", "[main]")
    )
    needed = "[radiance, depth, normal_geometric, base_color, roughness, metallic]"
    text = text.replace("[radiance, depth, instance, valid]", needed)
    found, entries = {}, {}
    for name, more in (("plain", ""), ("seen", SENSOR), ("again", SENSOR.replace("1\n", "2\n"))):
        file.write_text(text + more)
        assert run_dataset(file, tmp_path / name).made == 2
        renders = tmp_path / name / "renders"
        found[name] = checksums(renders)
        (manifest,) = renders.rglob("manifest.json")
        entries[name] = json.loads(manifest.read_text())["views"]
        del found[name][manifest.relative_to(renders).as_posix()]
    truth = found["plain"]
    assert {name: found["seen"][name] for name in truth} == truth
    added = found["seen"].keys() - truth.keys()
    assert {Path(name).name for name in added} == NAMES and len(added) == 2 * len(NAMES)
    # Another seed changes the noise and nothing else; no two views have the same.
    assert found["again"].keys() == found["seen"].keys()
    assert {name for name in truth if found["again"][name] != truth[name]} == set()
    assert all(found["again"][name] != found["seen"][name] for name in added)
    assert len({found["seen"][name] for name in added}) == len(added)
    for view, entry in entries["seen"].items():
        told = {**entry, "files": {k: v for k, v in entry["files"].items() if "sensor" not in k}}
        assert told.pop("sensor")["noise"]["iso"] == 800
        assert told == entries["plain"][view]
        assert {Path(v).name for k, v in entry["files"].items() if "sensor" in k} == NAMES
