"""What import looks at beside reading: the right importer, and whether compose would refuse."""

import shlex
from pathlib import Path
from typing import Final

from openrooms_usd.capture import Capture
from openrooms_usd.errors import InputError

_ARCHIVES: Final = (".zip", ".tar", ".tgz", ".gz", ".bz2", ".xz", ".7z", ".rar")
# What reads files of these endings, whatever they were given to.
_READERS: Final = {
    **dict.fromkeys(
        (".ply", ".pcd", ".obj", ".glb", ".stl", ".off", ".las", ".laz", ".e57", ".xyz", ".pts"),
        "scan",
    ),
    ".usdz": "roomplan",
    ".pkl": "sunrgbd",
    ".sens": "scannet",
    ".xml": "openrooms-xml",
}
# What folders hold that an importer reads whole.
_FOLDERS: Final = (
    ("*_vh_clean_2.ply", "scannet"),
    ("*.sens", "scannet"),
    ("*_3dod_mesh.ply", "arkitscenes"),
    ("Annotations", "s3dis"),
    ("full_annotations.json", "scan2cad"),
)
# Scans whose walls stand all round, this part of the azimuths, are not searched for rooms.
_ALL_ROUND: Final = 0.75


def check_archive(source: Path) -> None:
    """Refuse a packed folder.

    Raises:
        InputError: It is one.
    """
    if source.suffix.lower() in _ARCHIVES and source.is_file():
        raise InputError(
            "this is a packed folder or file",
            place=source,
            remedy="unzip it, and give what is in it",
        )


def hint_importer(kind: str, source: Path, error: InputError) -> None:
    """Say in an importer's error which one reads files of that ending, or such a folder."""
    if not str(error.place or "").startswith(str(source)):
        return
    other = _folder_reader(kind, source) if source.is_dir() else _file_reader(kind, source)
    if other:
        error.remedy = f"{error.remedy}; or {other}" if error.remedy else f"use {other}"


def _file_reader(kind: str, source: Path) -> str:
    ending = source.suffix.lower()
    reader = _READERS.get(ending, kind)
    return "" if reader == kind else f"`orusd import {reader}`, which reads {ending} files"


def _folder_reader(kind: str, folder: Path) -> str:
    """What reads a folder that another importer refused, or a file in it; empty if nothing does."""
    for pattern, reader in _FOLDERS:
        if any(folder.glob(pattern)):
            return "" if reader == kind else f"`orusd import {reader}`, which reads such folders"
    known = sorted(path for path in folder.iterdir() if path.suffix.lower() in _READERS)
    if not known:
        return ""
    reader = _READERS[known[0].suffix.lower()]
    return f"what is in it: `orusd import {reader} {shlex.quote(str(known[0]))}`"


def check_scan(capture: Capture, source: Path) -> str:
    """Look whether compose would find a room in a scan.

    Args:
        capture: With points, without a floor.
        source: The file or folder, for messages.

    Returns:
        What compose would say of a scan that shows too little without `partial: true`; empty where
        it would say nothing.

    Raises:
        InputError: Compose would refuse it in any case; its own words.
    """
    # What finds rooms in points takes a second to import.
    from openrooms_usd.scan.points.thinning import thin
    from openrooms_usd.scan.reconstruction import VOXEL_M
    from openrooms_usd.scan.rooms.layout import LayoutOptions, find_layout
    from openrooms_usd.scan.rooms.levelling import level

    assert capture.cloud is not None
    cloud = thin(capture.cloud, VOXEL_M)
    try:
        stands = level(cloud)
    except InputError as error:
        error.place = error.place or str(source)
        raise
    if stands.coverage >= _ALL_ROUND:
        return ""
    try:
        single = len(capture.frames) == 1
        find_layout(cloud.moved(stands.level_from_scan), stands, LayoutOptions(partial=single))
    except InputError as error:
        return f"compose refuses the scan as it is: {error.message}; remedy: {error.remedy}"
    return ""
