"""What a backend cannot have is said before it is tried."""

from pathlib import Path

import pytest

from openrooms_usd.errors import RenderError
from openrooms_usd.render.scene import gathering
from openrooms_usd.render.scene.translate import translate
from orusd_mitsuba import limits
from tests.crowd import crowd


def test_instances_that_do_not_fit_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gathering, "LEAST_SAVED_TRIANGLES", 1)
    monkeypatch.setattr(gathering, "_LEAST_SAVED_BY_ONE", 1)
    scene = translate(crowd(str(tmp_path / "none.png")).stage)
    # Sides, lids and tips of eight boxes.
    expanded = 8 * (10 + 2 + 4)
    assert limits.instances_advice(scene) == ""
    monkeypatch.setattr(limits, "_MANY_EXPANDED_TRIANGLES", expanded)
    assert "--variant scalar" in limits.instances_advice(scene)
    monkeypatch.setattr(limits, "_MANY_EXPANDED_TRIANGLES", expanded + 1)
    assert limits.instances_advice(scene) == ""
    monkeypatch.setattr(limits, "_MANY_EXPANDED_TRIANGLES", 1)
    monkeypatch.setattr(limits, "_memory", lambda: 100.0 * expanded)
    with pytest.raises(RenderError) as caught:
        limits.instances_advice(scene)
    assert "--variant scalar" in str(caught.value.remedy)
