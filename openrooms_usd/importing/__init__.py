"""A capture becomes a folder: a room.yaml beside what was read.

``captures`` reads, copies and describes, and says what compose would refuse and which importer it
is; ``text`` is the description, short and to be changed, with what the capture knows itself.
"""

from openrooms_usd.importing.captures import ROOM, ImportedRoom, described_capture, import_capture

__all__ = ["ROOM", "ImportedRoom", "described_capture", "import_capture"]
