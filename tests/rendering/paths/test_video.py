"""Videos: read back as they were written, the same bytes for the same frames."""

import importlib
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.rendering.paths import video

SIZE = (48, 32)


def frames() -> list[np.ndarray]:
    shade = np.linspace(40, 200, SIZE[0])[None, :, None] * np.ones((SIZE[1], 1, 3))
    return [np.clip(shade + 8 * number, 0, 255).astype(np.uint8) for number in range(6)]


def test_colours_are_those_of_bt709() -> None:
    for color, expected in (
        ((0, 0, 0), (16, 128, 128)),
        ((255, 255, 255), (235, 128, 128)),
        ((255, 0, 0), (63, 102, 240)),
        ((0, 0, 255), (32, 240, 118)),
    ):
        planes = video.yuv420(np.full((4, 6, 3), color, np.uint8))
        assert planes.shape == (6, 6)
        found = planes[:4].flat[0], planes[4].flat[0], planes[5].flat[0]
        np.testing.assert_allclose(found, expected, atol=1)


def test_a_video_reads_back(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    for name in ("one.webm", "two.webm"):
        with video.writing(tmp_path / name, SIZE, 12) as encoder:
            for frame in frames():
                encoder.add(frame)
    assert (tmp_path / "one.webm").read_bytes() == (tmp_path / "two.webm").read_bytes()
    with av.open(str(tmp_path / "one.webm")) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.average_rate) == ("libvpx-vp9", 12) or (
            "vp9" in stream.codec_context.name and stream.average_rate == 12
        )
        found = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
    assert len(found) == 6
    for shown, given in zip(found, frames(), strict=True):
        assert shown.shape == (SIZE[1], SIZE[0], 3)
        assert np.abs(shown.astype(float) - given).mean() < 4.0


def test_what_cannot_be_encoded_is_refused_first(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="33x32"):
        video.check((33, 32))

    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(MissingPackageError, match="package 'av'"):
        video.check(SIZE)
