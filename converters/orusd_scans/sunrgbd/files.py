"""The files of SUN RGB-D, one by one: calibration, boxes, points, and MMDetection3D's index."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedBox
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.unpickling import read_pickled
from orusd_scans.frames import intrinsics
from orusd_scans.records import Node, number, text
from orusd_scans.scanned import broken, cloud_of, counted, line_of_numbers, opened, size_of
from orusd_scans.worldframe import MAX_COORDINATE_M, proper

# The ten classes of VoteNet and MMDetection3D, by their numbers.
CLASSES: Final = (
    "bed",
    "table",
    "sofa",
    "chair",
    "toilet",
    "desk",
    "dresser",
    "night_stand",
    "bookshelf",
    "bathtub",
)
_NAMES: Final = ("x", "y", "z", "red", "green", "blue")
_MAX_SIZE_M: Final = 1e3  # metres
_LABEL_FIELDS: Final = 13
# One frame has some 50,000 points of 6 numbers.
_MOST_NUMBERS: Final = 1 << 26


@dataclass(frozen=True, eq=False)
class Box:
    """A box of an index: its size (3,) full, the first along its front; radians from x to y."""

    label: str
    center: Array
    size: Array
    angle: float


@dataclass(frozen=True, eq=False)
class Entry:
    """A frame of an index.

    Attributes:
        id: The name of its points without ending.
        points: The file of its points.
        features: Numbers of each point.
        projection: (3, 3) from upright depth to pixels.
        size: Width and height of the picture.
        picture: Its name.
        boxes: What was annotated.
    """

    id: str
    points: str
    features: int
    projection: Array
    size: tuple[int, int]
    picture: str | None
    boxes: tuple[Box, ...]


def facing(identifier: str, label: str, center: Array, size: Array, angle: float) -> CapturedBox:
    """A box whose front faces a horizontal direction.

    Args:
        identifier: Its name.
        label: Its class.
        center: (3,) metres.
        size: (3,) full sizes along the front's direction, across it, and up.
        angle: Of the front's direction, radians counter-clockwise from x.
    """
    c, s = math.cos(angle), math.sin(angle)
    back, right = np.array([-c, -s, 0.0]), np.array([-s, c, 0.0])
    return CapturedBox(
        id=identifier,
        label=label,
        center=center,
        rotation=np.column_stack([right, back, [0.0, 0.0, 1.0]]),
        size=size[[1, 0, 2]],
    )


def read_calibration(path: Path) -> tuple[Array, Array]:
    """(3, 3) tilt and (3, 3) intrinsics of VoteNet's ``calib/N.txt``: two lines, by columns.

    Raises:
        InputError: It is missing, or holds no rotation or no intrinsics.
    """
    lines = _lines(path)
    if len(lines) < 2:
        raise broken(path, "two lines of nine numbers are expected")
    tilt, K = (
        line_of_numbers(line, 9, path, i).reshape(3, 3).T for i, line in enumerate(lines[:2])
    )
    proper(tilt, Node(None, path, "line 1"))
    return tilt, intrinsics(Node(K.tolist(), path, "line 2"))


def read_boxes(path: Path, frame: str) -> tuple[CapturedBox, ...]:
    """The boxes of VoteNet's ``label/N.txt``: half sizes across the front, along it, and up.

    Raises:
        InputError: A line is not a box.
    """
    found = []
    for i, line in enumerate(_lines(path)):
        words = line.split()
        if len(words) < _LABEL_FIELDS:
            raise broken(path, f"line {i + 1}: a class and 12 numbers are expected")
        values = line_of_numbers(" ".join(words[1:_LABEL_FIELDS]), _LABEL_FIELDS - 1, path, i)
        half = values[[8, 7, 9]]
        if not (half > 0.0).all() or not values[10:12].any():
            raise broken(path, f"line {i + 1}: a box needs sizes above zero and a direction")
        angle = math.atan2(values[11], values[10])
        label = text(Node(words[0], path, f"line {i + 1}"))
        found.append(facing(f"{frame}_{i}", label, values[4:7], 2.0 * half, angle))
    return tuple(found)


def read_matrix(path: Path, notes: list[str]) -> Cloud:
    """The points of VoteNet's ``depth/N.mat``: a matrix ``instance`` (N, 6).

    Raises:
        InputError: It cannot be read, or has no such matrix.
    """
    from scipy.io import loadmat, whosmat

    with opened(path, "array") as opened_stream:
        stream: Any = opened_stream
        try:
            kinds = {name: (shape, kind) for name, shape, kind in whosmat(stream)}
            shape, kind = kinds.get("instance", ((), "nothing"))
            # Of nested kinds the reader runs out of stack.
            if kind not in ("double", "single") or math.prod(shape) > _MOST_NUMBERS:
                raise ValueError(f"'instance' is {kind} of {'x'.join(map(str, shape))}")
            stream.seek(0)
            found: Any = loadmat(stream, variable_names=["instance"]).get("instance")
        except Exception as error:
            raise broken(path, f"not a readable MAT file: {str(error)[:200]}") from error
    if not isinstance(found, np.ndarray) or found.dtype.kind != "f":
        raise broken(path, "it has no matrix of numbers named 'instance'")
    return _cloud(found, path, notes)


def read_points(path: Path, features: int, notes: list[str]) -> Cloud:
    """The points of a ``.bin`` file: single precision, so many numbers each.

    Raises:
        InputError: It is missing, or does not hold whole points.
    """
    with opened(path) as stream:
        size = size_of(stream)
        counted(path, str(size // (4 * features)))
        if size % (4 * features):
            raise broken(path, f"it holds no whole points of {features} numbers")
        values = np.fromfile(stream, "<f4").reshape(-1, features)
    return _cloud(values, path, notes)


def _cloud(values: NDArray[Any], path: Path, notes: list[str]) -> Cloud:
    if values.ndim != 2 or values.shape[1] < 3:
        raise broken(path, f"points are rows of three numbers or six, not {values.shape}")
    names = _NAMES if values.shape[1] >= len(_NAMES) else _NAMES[:3]
    return cloud_of({name: values[:, i] for i, name in enumerate(names)}, path, notes)


def read_index(path: Path) -> list[Entry]:
    """The frames of MMDetection3D's pickled index; nothing in it is executed.

    Raises:
        InputError: It is not such an index, or holds something else than plain data.
    """
    root = Node(read_pickled(path), path)
    if not isinstance(root.value, dict) or not isinstance(root.value.get("data_list"), list):
        raise root.error("this is not an index of MMDetection3D", "give one that has a data_list")
    names = _class_names(root)
    return [_entry(node, names) for node in root.items("data_list")]


def _class_names(root: Node) -> dict[int, str]:
    """The index's own classes, or the ten usual ones."""
    meta = root.get("metainfo")
    own = meta.get("categories") if meta is not None else None
    if own is None:
        return dict(enumerate(CLASSES))
    if not isinstance(own.value, dict) or not all(type(v) is int for v in own.value.values()):
        raise own.error("classes with their numbers expected")
    return {value: text(Node(name, own.file, own.path)) for name, value in own.value.items()}


def _entry(node: Node, names: dict[int, str]) -> Entry:
    camera = node.need("images").need("CAM0")
    stored = node.need("lidar_points")
    points = text(stored.need("lidar_path"))
    picture = camera.get("img_path")
    features = int(number(stored.need("num_pts_feats"), 64))
    if features < 3:
        raise stored.error("points have three numbers or more", "make the index again")
    return Entry(
        id=Path(points).stem,
        points=Path(points).name,
        features=features,
        projection=camera.need("depth2img").numbers(9, 1e6).reshape(3, 3),
        size=tuple(int(number(camera.need(key), 65_536)) for key in ("width", "height")),  # type: ignore[arg-type]
        picture=Path(text(picture)).name if picture is not None else None,
        boxes=tuple(_box(one, names) for one in node.items("instances")),
    )


def _box(node: Node, names: dict[int, str]) -> Box:
    values = node.need("bbox_3d").numbers(7, MAX_COORDINATE_M)
    if not ((values[3:6] > 0.0) & (values[3:6] < _MAX_SIZE_M)).all():
        raise node.error("a box needs sizes above zero, metres", "make the index again")
    label = int(number(node.need("bbox_label_3d"), 1e6))
    return Box(names.get(label, "object"), values[:3], values[3:6], float(values[6]))


def camera_of_projection(projection: Array, node: Node) -> tuple[Array, Array]:
    """Intrinsics and world_from_camera (3, 3) each, of their product K R.

    Args:
        projection: (3, 3) K R, from the world to pixels.
        node: Where it stands, for messages.

    Raises:
        InputError: It is not such a product.
    """
    from scipy.linalg import rq

    if abs(float(np.linalg.det(projection))) < 1e-6:
        raise node.error("depth2img is not a projection", "make the index again")
    K, turn = (np.asarray(part, dtype=np.float64) for part in rq(projection))
    # The RQ decomposition leaves signs undetermined: focal lengths are positive.
    signs = np.sign(np.diag(K))
    K, turn = K * signs, signs[:, None] * turn
    proper(turn, node)
    return K / K[2, 2], turn.T


def _lines(path: Path) -> list[str]:
    return [line for line in untrusted.read_text(path).splitlines() if line.strip()]
