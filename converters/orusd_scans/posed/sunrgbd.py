"""One photograph of SUN RGB-D, with its depth: a raw frame, or VoteNet's folder of one."""

from dataclasses import replace
from pathlib import Path
from typing import Final

from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.errors import InputError
from orusd_scans.posed.pictures import files_of
from orusd_scans.sunrgbd.importer import SunRgbdImporter

# Depth maps are rotated by three bits: up to 8.19 m that is a factor of eight.
_DEPTH_UNIT_M: Final = 0.001 / 8.0
_DEPTHS: Final = ("depth_bfx", "depth")


class SunRgbdPhotographs:
    """Reads the folder of a frame, or the index of one."""

    reads = "a frame with intrinsics.txt and extrinsics/, or depth/ and calib/ (SUN RGB-D)"

    def recognises(self, path: Path) -> bool:
        """Whether there is a frame."""
        if path.is_dir():
            votenet = (path / "depth").is_dir() and (path / "calib").is_dir()
            return votenet or (
                (path / "intrinsics.txt").is_file() and (path / "extrinsics").is_dir()
            )
        return path.suffix.lower() == ".pkl"

    def read(self, path: Path) -> PosedPhotographs:
        """Read the frame.

        Raises:
            InputError: It lacks files, there are several frames, or one holds nonsense.
        """
        if len(list((path / "calib").glob("*.txt"))) > 1:
            raise InputError(
                "several frames are here, which share no world",
                place=path,
                remedy="give the folder of one raw frame",
            )
        capture = SunRgbdImporter().read(path)
        folder = path if path.is_dir() else path.parent
        maps = [
            f"{name}/{file.name}" for name in _DEPTHS for file in files_of(path / name, (".png",))
        ]
        depth = maps[0] if maps else None
        frames = tuple(
            replace(frame, depth=depth, depth_unit=_DEPTH_UNIT_M) for frame in capture.frames
        )
        return PosedPhotographs(frames, folder, "sunrgbd", True, True, capture.notes)
