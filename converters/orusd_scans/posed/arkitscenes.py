"""The low-resolution photographs of a scan of ARKitScenes, with their depth."""

from dataclasses import replace
from pathlib import Path

from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from orusd_scans.arkitscenes.importer import TRAJECTORY, captured_frames, frames_folder, read_path


class ARKitScenesPhotographs:
    """Reads the folder of a scan."""

    reads = f"a folder with {TRAJECTORY} (ARKitScenes)"

    def recognises(self, path: Path) -> bool:
        """Whether there is a trajectory."""
        return frames_folder(path) is not None

    def read(self, path: Path) -> PosedPhotographs:
        """Read the photographs on the trajectory.

        Raises:
            InputError: The trajectory or intrinsics are missing, or hold nonsense.
        """
        folder = frames_folder(path)
        if folder is None:
            raise InputError(f"no {TRAJECTORY} is here", place=path, remedy=f"give {self.reads}")
        notes: list[str] = []
        frames = captured_frames(folder, read_path(folder / TRAJECTORY), notes)
        deep = tuple(_with_depth(frame, folder) for frame in frames)
        return PosedPhotographs(deep, folder, "arkitscenes", True, True, tuple(notes))


def _with_depth(frame: CapturedFrame, folder: Path) -> CapturedFrame:
    """A frame with its depth map, millimetres, where that is there."""
    name = f"lowres_depth/{frame.id}.png"
    return replace(frame, depth=name) if (folder / name).is_file() else frame
