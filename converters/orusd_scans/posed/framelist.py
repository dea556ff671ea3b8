"""Our own JSON list of photographs, in metres with Z up."""

from pathlib import Path
from typing import Final

from openrooms_usd.appearance.photographs import PosedPhotographs
from orusd_scans.frames import read_frames
from orusd_scans.records import read_json

_USUAL: Final = "frames.json"


class FrameList:
    """Reads a list of frames, or the folder of one named ``frames.json``."""

    reads = "a JSON list of frames (id, picture, resolution, K, world_from_camera)"

    def recognises(self, path: Path) -> bool:
        """Whether there is such a list."""
        if path.is_dir():
            return (path / _USUAL).is_file()
        if path.suffix.lower() != ".json":
            return False
        root = read_json(path)
        listed = root.value if isinstance(root.value, list) else None
        if listed is None and isinstance(root.value, dict):
            listed = root.value.get("frames")
        first = listed[0] if isinstance(listed, list) and listed else None
        return isinstance(first, dict) and "world_from_camera" in first

    def read(self, path: Path) -> PosedPhotographs:
        """Read the list.

        Raises:
            InputError: It holds nonsense.
        """
        file = path / _USUAL if path.is_dir() else path
        return PosedPhotographs(read_frames(file), file.parent, "frames", True, True)
