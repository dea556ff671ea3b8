"""Small pictures of materials: the same bytes each time, and as bright as what they show."""

import io

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.library.textures import make
from openrooms_usd.library.thumbnails import SIZE, ball, thumbnail


def test_they_are_the_same_with_and_without_a_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    first, again = thumbnail("oak_planks", 3), thumbnail("oak_planks", 3)
    monkeypatch.setenv("ORUSD_CACHE", "off")
    assert first == again == thumbnail("oak_planks", 3)
    assert first != thumbnail("oak_planks", 4) and len(first) < 20_000


def test_a_picture_opens() -> None:
    image = pytest.importorskip("PIL.Image").open(io.BytesIO(thumbnail("nappa")))
    assert image.size == (SIZE, SIZE) and image.mode == "RGBA"


def test_brighter_materials_make_brighter_balls_round_and_lit_from_the_upper_left() -> None:
    shown = [ball(make("nappa", 0, color=(v, v, v), resolution=64)) for v in (0.05, 0.2, 0.6)]
    inside = shown[0][..., 3] > 0
    assert inside.mean() == pytest.approx(np.pi / 4 / 1.02**2, abs=0.01)
    means = [one[inside][:, :3].mean() for one in shown]
    assert means == sorted(means)
    half = SIZE // 2
    assert shown[1][:half, :half, :3].mean() > shown[1][half:, half:, :3].mean()


def test_no_such_family() -> None:
    with pytest.raises(InputError):
        thumbnail("dragon_scales")
