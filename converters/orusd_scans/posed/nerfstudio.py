"""``transforms.json`` of nerfstudio and instant-ngp, which many capture apps export.

Cameras look along -Z with Y up (OpenGL); intrinsics are of all frames, or of each. Pixels count
from the corner of the first one, as ours do. What COLMAP found has no scale, and its vertical is a
guess. ``applied_transform`` says what was done already, so nothing is done about it.
"""

import math
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedFrame
from orusd_scans.formats.depthpicture import picture_size
from orusd_scans.posed.pictures import by_number, identifiers, name_inside, pinhole
from orusd_scans.records import Node, flag, number, positive, read_json, text
from orusd_scans.worldframe import rigid

_USUAL: Final = ("transforms.json", "transforms_train.json")
_PINHOLES: Final = ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "PERSPECTIVE")
_FISHEYE: Final = "OPENCV_FISHEYE"
# What converters of COLMAP's models leave in the file, or beside it.
_COLMAP_KEYS: Final = ("aabb_scale", "applied_scale")
_COLMAP_FRAME_KEYS: Final = ("colmap_im_id", "sharpness")
_COLMAP_FOLDERS: Final = ("colmap", "sparse")
_MAX_PIXELS: Final = 1e6
_MAX_COEFFICIENT: Final = 1e6


class NerfstudioPhotographs:
    """Reads ``transforms.json``, or the folder that holds it."""

    reads = "transforms.json (nerfstudio, instant-ngp, exports of capture apps)"

    def recognises(self, path: Path) -> bool:
        """Whether there is such a file."""
        if path.is_dir():
            return any((path / name).is_file() for name in _USUAL)
        if path.suffix.lower() != ".json":
            return False
        value = read_json(path).value
        frames = value.get("frames") if isinstance(value, dict) else None
        first = frames[0] if isinstance(frames, list) and frames else None
        return isinstance(first, dict) and "transform_matrix" in first

    def read(self, path: Path) -> PosedPhotographs:
        """Read the file.

        Raises:
            InputError: A pose, an intrinsic or a lens makes no sense.
        """
        if path.is_dir():
            path = next((path / n for n in _USUAL if (path / n).is_file()), path / _USUAL[0])
        root, folder = read_json(path), path.parent
        named = [(_name(node, folder), node) for node in root.items("frames")]
        named.sort(key=lambda pair: by_number(pair[0]))
        names, nodes = [name for name, _ in named], [node for _, node in named]
        frames = tuple(
            _frame(node, root, identifier, name, folder)
            for node, identifier, name in zip(nodes, identifiers(names), names, strict=True)
        )
        notes = _unread_depth(nodes)
        matched = _is_matched(root, nodes, folder)
        # Apps whose own tracking says where up is forbid that it is guessed again.
        tracked = not matched and root.value.get("orientation_override") == "none"
        if matched:
            notes.append("the cameras come from matched photographs: their scale is not known")
        metric = tracked or (not matched and any(frame.depth for frame in frames))
        return PosedPhotographs(frames, folder, "nerfstudio", metric, tracked, tuple(notes))


def _name(node: Node, folder: Path) -> str:
    file = node.need("file_path")
    if not isinstance(file.value, str):
        raise file.error("the name of a picture expected", "write its path in the folder")
    return name_inside(folder, file.value, file)


def _frame(node: Node, root: Node, identifier: str, name: str, folder: Path) -> CapturedFrame:
    matrix = rigid(node.need("transform_matrix"))
    size = _resolution(node, root, folder / name)
    fisheye, distortion = _lens(node, root)
    return CapturedFrame(
        id=identifier,
        world_from_camera=matrix @ np.diag([1.0, -1.0, -1.0, 1.0]),
        K=_intrinsics(node, root, size),
        resolution=size,
        picture=name,
        distortion=distortion,
        fisheye=fisheye,
        depth=_depth(node, folder),
    )


def _either(node: Node, root: Node, key: str) -> Node | None:
    """A value of the frame, or of all frames."""
    return node.get(key) or root.get(key)


def _resolution(node: Node, root: Node, picture: Path) -> tuple[int, int]:
    sides = [_either(node, root, key) for key in ("w", "h")]
    if sides[0] is None or sides[1] is None:
        if not picture.is_file():
            raise node.error("neither w and h nor the picture are here", "add w and h, in pixels")
        return picture_size(picture)
    width, height = (positive(side, _MAX_PIXELS) for side in sides if side is not None)
    if width % 1 or height % 1:
        raise node.error("w and h are whole pixels", "correct w and h")
    return int(width), int(height)


def _intrinsics(node: Node, root: Node, size: tuple[int, int]) -> Array:
    def said(key: str) -> float | None:
        found = _either(node, root, key)
        return None if found is None else number(found, _MAX_PIXELS)

    fx, fy = said("fl_x"), said("fl_y")
    if fx is None and (angle := said("camera_angle_x")) is not None:
        if not 0.0 < angle < math.pi:
            raise node.error(f"camera_angle_x of {angle:g} radians makes no sense")
        fx = 0.5 * size[0] / math.tan(0.5 * angle)
    if fx is None:
        raise node.error("neither fl_x nor camera_angle_x is there", "add fl_x, in pixels")
    cx, cy = said("cx"), said("cy")
    return pinhole(
        fx,
        fx if fy is None else fy,
        0.5 * size[0] if cx is None else cx,
        0.5 * size[1] if cy is None else cy,
        node,
    )


def _lens(node: Node, root: Node) -> tuple[bool, tuple[float, ...]]:
    """Whether it is a fisheye, and its coefficients as OpenCV orders them."""
    named = _either(node, root, "camera_model")
    model = text(named) if named is not None else _PINHOLES[0]
    marked = _either(node, root, "is_fisheye")
    fisheye = model == _FISHEYE or (marked is not None and flag(marked))
    if named is not None and not fisheye and model not in _PINHOLES:
        known = ", ".join((*_PINHOLES, _FISHEYE))
        raise named.error(f"cameras of the model {model!r} are not read", f"these are: {known}")

    def k(key: str) -> float:
        found = _either(node, root, key)
        return 0.0 if found is None else number(found, _MAX_COEFFICIENT)

    radial = k("k1"), k("k2"), k("k3"), k("k4")
    if fisheye:
        return True, radial
    if radial[3] or k("k5") or k("k6"):
        raise node.error(
            "programs disagree about k4 to k6 of lenses other than fisheyes",
            "undistort the photographs first, or calibrate with k1, k2, p1, p2 and k3 alone",
        )
    given = radial[0], radial[1], k("p1"), k("p2"), radial[2]
    return False, (given if given[4] else given[:4]) if any(given) else ()


def _depth(node: Node, folder: Path) -> str | None:
    """The name of the depth map, where it is a picture."""
    file = node.get("depth_file_path")
    if file is None or not isinstance(file.value, str) or not _is_picture(file.value):
        return None
    return name_inside(folder, file.value, file)


def _is_picture(name: str) -> bool:
    return name.lower().endswith(".png")


def _unread_depth(nodes: list[Node]) -> list[str]:
    paths = [node.value.get("depth_file_path") for node in nodes]
    unread = sum(1 for path in paths if path is not None and not _is_picture(str(path)))
    return [f"{unread} depth maps are not read: only PNG files of 16 bits are"] if unread else []


def _is_matched(root: Node, nodes: list[Node], folder: Path) -> bool:
    """Whether the cameras were found by matching photographs, so that they have no scale."""
    return (
        any(key in root.value for key in _COLMAP_KEYS)
        or any(key in node.value for node in nodes for key in _COLMAP_FRAME_KEYS)
        or any((folder / name).is_dir() for name in _COLMAP_FOLDERS)
    )
