"""Prims of a translated stage that move rigidly, in the arrays and in renderers."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from openrooms_usd import adapters
from openrooms_usd.rendering import opening
from openrooms_usd.rendering.context import RenderContext as OpenedStage
from openrooms_usd.rendering.contract import MovingSession, RenderRequest
from openrooms_usd.rendering.scene import translate as translation
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.moving import MovingScene
from openrooms_usd.usd.places.settled import Motion, author_motions
from tests.opening import open_with

DESK, LAMP, CHAIR = (f"/World/Furniture/{name}" for name in ("desk", "table_lamp_0", "chair_0"))


def turn(degrees: float, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """A motion about the world's Z, then along it."""
    M = np.eye(4)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    M[:2, :2] = [[c, -s], [s, c]]
    M[:3, 3] = x, y, z
    return M


MOTIONS = {LAMP: turn(30, 0.6, -1.0, 0.3), CHAIR: turn(-20, 0.5, 0.6, 0.0)}


def moved_stage(path: Path) -> Usd.Stage:
    """The stage with `MOTIONS` as its own opinions, which knows nothing of moving arrays."""
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().subLayerPaths = [str(path)]
    for key in ("upAxis", "metersPerUnit"):
        value = Usd.Stage.Open(str(path)).GetRootLayer().pseudoRoot.GetInfo(key)
        stage.GetRootLayer().pseudoRoot.SetInfo(key, value)
    assert not author_motions(stage, [Motion(p, M, "before") for p, M in MOTIONS.items()])
    return stage


def corners_of(scene: Scene, path: str) -> np.ndarray:
    """All corners of triangles below a prim."""
    below = [scene.legend.part[piece.part].startswith(f"{path}/") for piece in scene.pieces]
    triangles = scene.triangles
    return triangles.corners[np.array(below)[triangles.pieces]]


def test_what_stands_below_a_prim_moves_with_it_and_nothing_else(composed_demo: Path) -> None:
    scene = translation.translate(Usd.Stage.Open(str(composed_demo)))
    moving = MovingScene(scene)
    assert moving.move(MOTIONS)
    for path in (DESK, LAMP, CHAIR, "/World/Room"):
        M = MOTIONS.get(path, np.eye(4))
        wanted = corners_of(scene, path) @ M[:3, :3].T + M[:3, 3]
        assert len(wanted) and np.allclose(corners_of(moving.scene, path), wanted, atol=1e-12)
    assert moving.scene.origin is scene.origin
    # The second time nothing has moved any more; patches that did not move are shared.
    now = moving.scene
    assert not moving.move(MOTIONS) and moving.scene is now
    assert moving.move({CHAIR: np.eye(4)})
    assert np.array_equal(corners_of(moving.scene, CHAIR), corners_of(scene, CHAIR))
    kept = [a is b for a, b in zip(now.patches, moving.scene.patches, strict=True)]
    assert any(kept) and not all(kept)


def test_the_nearest_prim_above_leads() -> None:
    stage = Usd.Stage.CreateInMemory()
    for path in ("/A", "/A/leaf", "/AB"):
        mesh = UsdGeom.Mesh.Define(stage, f"{path}/mesh")
        mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
        mesh.CreateFaceVertexCountsAttr([3])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
        mesh.CreateSubdivisionSchemeAttr("none")
        UsdGeom.XformCommonAPI(mesh).SetTranslate(Gf.Vec3d(0, 0, 0))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    moving = MovingScene(translation.translate(stage))
    moving.move({"/A": turn(0, 1.0), "/A/leaf": turn(0, 5.0)})
    assert corners_of(moving.scene, "/A/leaf")[..., 0].min() == 5.0
    assert sorted(corners_of(moving.scene, "/A")[..., 0].min(axis=1)) == [1.0, 5.0]
    assert corners_of(moving.scene, "/AB")[..., 0].min() == 0.0


@pytest.mark.parametrize("renderer", [pytest.param("mitsuba", marks=pytest.mark.slow), "preview"])
def test_a_moved_scene_renders_as_a_stage_that_was_moved(
    composed_demo: Path, renderer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against the same motions as opinions of the stage, a lamp's among them."""
    adapter = adapters.load(adapters.RENDERERS, renderer)
    channels = ("radiance", "depth", "normal", "instance")
    channels += ("radiance_i", "direct_i") if "direct_i" in adapter.channels else ()

    def pictures(opened: OpenedStage) -> dict[str, np.ndarray]:
        request = RenderRequest(opened.cameras[0], channels, 48, 36, samples=16)
        return {name: image.pixels for name, image in opened.render(request).images.items()}

    stage = Usd.Stage.Open(str(composed_demo))
    opened = open_with(adapter, stage)
    before = pictures(opened)
    monkeypatch.setattr(opening, "translate", None)
    opens: list[str] = []
    monkeypatch.setattr(opened, "_renderer", _Counting(adapter, opens))
    opened.move(MOTIONS)
    after = pictures(opened)
    assert len(opens) == (not isinstance(opened.session, MovingSession))
    monkeypatch.undo()
    wanted = pictures(open_with(adapter, moved_stage(composed_demo)))
    assert np.abs(before["depth"] - wanted["depth"]).max() > 0.3
    for name in ("depth", "normal", "instance"):
        assert np.quantile(np.abs(after[name] - wanted[name]), 0.99) < 1e-4, name
    # Direct light on the same samples; longer paths take other ways for a rounding here and there.
    for name in wanted:
        bounds = {"direct": (1e-5, 1e-3), "radiance": (0.05, 0.1)}.get(name.split("_")[0])
        if bounds and wanted[name].any():
            difference, mean = np.abs(after[name] - wanted[name]), wanted[name].mean()
            assert np.median(difference) < bounds[0] * mean, name
            assert after[name].mean() == pytest.approx(mean, rel=bounds[1]), name
    if "direct_0" in wanted:
        assert before["direct_0"].mean() != pytest.approx(wanted["direct_0"].mean(), rel=0.1)


class _Counting:
    """A renderer that counts how often it opens a scene."""

    def __init__(self, renderer: object, opens: list[str]) -> None:
        self._renderer, self._opens = renderer, opens
        self.channels = renderer.channels  # type: ignore[attr-defined]

    def open(self, *arguments: object) -> object:
        self._opens.append("open")
        return self._renderer.open(*arguments)  # type: ignore[attr-defined]
