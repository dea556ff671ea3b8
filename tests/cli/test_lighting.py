"""The commands ``relight``, ``probe`` and ``bake`` as a person meets them."""

from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering import probes
from openrooms_usd.rendering import relight as relighting
from openrooms_usd.rendering.bake import baking
from tests.commands import run


def test_relight_takes_words_and_numbers(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen: list[Any] = []

    def turned(view: Path, out: Path, how: Any) -> dict[str, Any]:
        seen.append((view, how))
        return {"lights": [{"name": "lamp_2", "factor": [0.0, 0.0, 0.0]}]}

    monkeypatch.setattr(relighting, "relight", turned)
    found = run(
        "relight",
        "a/left",
        "-o",
        str(tmp_path),
        *"--light lamp_2=off --light window_0=2.0 --light lamp_0=ON".split(),
        *("--temperature", "lamp_1=2700"),
    )
    assert found.exit_code == 0, found.output
    ((view, how),) = seen
    assert view == Path("a/left")
    assert how.scales == {"lamp_2": 0.0, "window_0": 2.0, "lamp_0": 1.0}
    assert how.kelvin == {"lamp_1": 2700.0}
    assert "lamp_2" in found.output


@pytest.mark.parametrize("text", ["lamp_2", "=1", "lamp_2=bright", "lamp_2=", "lamp_2=nan"])
def test_relight_refuses_what_is_no_pair(text: str, tmp_path: Path) -> None:
    found = run("relight", "a/left", "-o", str(tmp_path), "--light", text)
    assert found.exit_code == 2
    assert "lamp_2=0.5" in found.output


def test_probe_takes_positions(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen: list[Any] = []

    def made(stage: Path, out: Path, settings: Any, **how: Any) -> dict[str, Any]:
        seen.append((settings, how))
        return {"probes": [{"name": "probe_0", "estimated_robust_error": 0.01}]}

    monkeypatch.setattr(probes, "probe_stage", made)
    found = run(
        "probe",
        "scene.usda",
        "-o",
        str(tmp_path),
        *"--at -1,2,0.5 --at 0,0,1 --openings --resolution 64x32 --spp 8".split(),
    )
    assert found.exit_code == 0, found.output
    ((settings, how),) = seen
    assert how["at"] == ((-1.0, 2.0, 0.5), (0.0, 0.0, 1.0))
    assert (how["at_openings"], settings.resolution, settings.samples) == (True, (64, 32), 8)


@pytest.mark.parametrize(
    "option", [("--at", "1,2"), ("--at", "a,b,c"), ("--resolution", "big"), ("--spp", "many")]
)
def test_probe_refuses_what_it_cannot_read(option: tuple[str, str], tmp_path: Path) -> None:
    assert run("probe", "scene.usda", "-o", str(tmp_path), *option).exit_code == 2


def test_bake_says_what_it_made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen: list[Any] = []

    def made(stage: Path, out: Path, settings: Any, layout: Any, **how: Any) -> dict[str, Any]:
        seen.append((settings, layout))
        return {
            "texel": {"asked_m": 0.1, "side_m": 0.2},
            "lights": [{}, {}],
            "left_out": [{}],
            "atlases": [{"size": [64, 32], "lit_texels": 1234}],
            "estimated_error": 0.01,
            "layer": "lightmaps.usda",
        }

    monkeypatch.setattr(baking, "bake_stage", made)
    found = run(
        "bake",
        "scene.usda",
        "-o",
        str(tmp_path),
        *"--texel 0.1 --spp 8 --atlas 512 --max-texels 2048 --variant llvm".split(),
    )
    assert found.exit_code == 0, found.output
    ((settings, layout),) = seen
    assert settings == RenderSettings(samples=8, options={"variant": "llvm"})
    assert layout == baking.AtlasLayout(0.1, 512, 2048)
    assert "64x32, 1,234 texels" in found.output and "20 cm, not 10 cm" in found.output


def test_bake_offers_what_the_core_has_by_default() -> None:
    from openrooms_usd.cli.baking import bake

    offered = {option.name: option.default for option in bake.params}
    own = baking.AtlasLayout()
    assert (offered["texel"], offered["side"], offered["max_texels"]) == (
        own.texel_m,
        own.side,
        own.most_texels,
    )
