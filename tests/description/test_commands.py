import json
import os
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from openrooms_usd import adapters, doctor
from openrooms_usd.cli import describing, orusd
from openrooms_usd.description import load_room
from openrooms_usd.description.schema import room_schema
from openrooms_usd.errors import MissingPackageError, OutputError


def test_init_writes_a_room_that_loads_and_its_schema(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "room"
    result = CliRunner().invoke(orusd, ["init", str(folder)])
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in folder.iterdir()) == ["room.schema.json", "room.yaml"]
    room = load_room(folder / "room.yaml")
    assert {thing.category for thing in room.furniture.objects} == {
        *("chair", "table", "sofa", "cabinet", "floor_lamp", "table_lamp", "ceiling_lamp")
    }
    first = (folder / "room.yaml").read_text().splitlines()[0]
    assert first == "# yaml-language-server: $schema=./room.schema.json"
    assert json.loads((folder / "room.schema.json").read_text()) == room_schema()


@pytest.mark.parametrize("name", ["room.yaml", "room.schema.json"])
def test_init_overwrites_nothing(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    result = CliRunner().invoke(orusd, ["init", str(tmp_path)])
    assert isinstance(result.exception, OutputError)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


def test_init_into_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    result = CliRunner().invoke(orusd, ["init", str(tmp_path / "taken")])
    assert isinstance(result.exception, OutputError)


def test_schema_prints_the_schema() -> None:
    result = CliRunner().invoke(orusd, ["schema"])
    assert result.exit_code == 0
    assert json.loads(result.output) == room_schema()


class Healthy:
    def diagnose(self) -> dict[str, str]:
        return {"fast": "works"}


class Silent:
    pass


def with_renderer(monkeypatch: pytest.MonkeyPatch, renderer: object) -> None:
    def load(group: str, name: str) -> object:
        if isinstance(renderer, Exception):
            raise renderer
        return renderer

    monkeypatch.setattr(adapters, "load", load)


def test_doctor_reports_as_text_and_as_json(monkeypatch: pytest.MonkeyPatch) -> None:
    with_renderer(monkeypatch, Healthy())
    text = CliRunner().invoke(describing.doctor).output
    for expected in ("python", "usd-core", "Embree", "renderer mitsuba", "fast", "works"):
        assert expected in text
    result = CliRunner().invoke(describing.doctor, ["--json"])
    data = json.loads(result.output)
    assert result.exit_code == 0
    assert data["healthy"] is True
    assert data["system"]["python"] == sys.version.split()[0]
    assert data["renderers"]["mitsuba"] == {"fast": "works"}
    assert data["system"]["caches"] == os.environ["ORUSD_CACHE"]


def test_doctor_names_the_extras_that_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    with_renderer(monkeypatch, Healthy())
    real = doctor._version
    monkeypatch.setattr(doctor, "_version", lambda name: None if name == "pyoidn" else real(name))
    result = CliRunner().invoke(describing.doctor)
    assert result.exit_code == 0
    assert "not installed: pip install openrooms-usd[denoise]" in result.output
    monkeypatch.setattr(doctor, "_version", lambda name: "1.2.3")
    assert doctor.diagnose().extras["denoise (pyoidn)"] == "1.2.3"


def test_a_renderer_without_a_diagnosis_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    with_renderer(monkeypatch, Silent())
    assert doctor.diagnose().renderers["mitsuba"] == {"state": "installed"}


def test_a_broken_renderer_is_reported_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    with_renderer(monkeypatch, MissingPackageError("no mitsuba", remedy="pip install mitsuba"))
    found = doctor.diagnose()
    assert found.renderers["mitsuba"] == {"state": "not usable: no mitsuba"}
    assert "pip install mitsuba" in found.remedies


def test_without_embree_the_slower_caster_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with_renderer(monkeypatch, Healthy())
    monkeypatch.setattr(doctor, "_RAY_CASTERS", (("no_such_module", "", ""), ("json", "slow", "x")))
    found = doctor.diagnose()
    assert found.ray_caster is not None
    assert found.ray_caster.startswith("slow")
    assert "x" in found.remedies
    monkeypatch.setattr(doctor, "_RAY_CASTERS", ())
    assert not doctor.diagnose().healthy
    assert CliRunner().invoke(describing.doctor).exit_code == 1
