"""Writers of the forms of posed photographs: the same walk in each of them."""

import json
import struct
from pathlib import Path

import numpy as np
import OpenImageIO
from scipy.spatial.transform import Rotation

SIZE = (64, 48)
K = np.array([[50.0, 0.0, 31.5], [0.0, 51.0, 24.25], [0.0, 0.0, 1.0]])
LENS = (-0.1, 0.02, 0.003, -0.004)
COUNT = 12


def poses() -> list[np.ndarray]:
    """World from camera, Z up: none is the inverse or the transpose of another."""
    found = []
    for i in range(COUNT):
        M = np.eye(4)
        M[:3, :3] = Rotation.from_euler(
            "zyx", [20 * i, 5 * i - 20, -80 - i], degrees=True
        ).as_matrix()
        M[:3, 3] = [0.3 * i, 1.0 - 0.1 * i * i, 1.4]
        found.append(M)
    return found


def picture(path: Path, value: int = 100) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    deep = path.suffix == ".png"
    values = np.full((SIZE[1], SIZE[0], 1 if deep else 3), value, np.uint16 if deep else np.uint8)
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(*SIZE, values.shape[2], str(values.dtype)))
    image.set_pixels(OpenImageIO.ROI(), values)
    image.write(str(path))


def pictures(folder: Path, names: list[str]) -> list[str]:
    for name in names:
        picture(folder / name)
    return names


def colmap(folder: Path, *, binary: bool = True, lens: str = "OPENCV") -> Path:
    """A project with images/ and sparse/0; the images are not in the order of their names."""
    names = pictures(folder / "images", [f"walk {i}.jpg" for i in range(COUNT)])
    model = folder / "sparse/0"
    model.mkdir(parents=True)
    fx, fy, cx, cy = K[0, 0], K[1, 1], K[0, 2], K[1, 2]
    number, parameters = {
        "OPENCV": (4, [fx, fy, cx, cy, *LENS]),
        "PINHOLE": (1, [fx, fy, cx, cy]),
        "SIMPLE_PINHOLE": (0, [fx, cx, cy]),
        "SIMPLE_RADIAL": (2, [fx, cx, cy, LENS[0]]),
        "RADIAL": (3, [fx, cx, cy, *LENS[:2]]),
        "OPENCV_FISHEYE": (5, [fx, fy, cx, cy, *LENS]),
        "FULL_OPENCV": (6, [fx, fy, cx, cy, *LENS, 0.1, 0.2, 0.3, 0.4]),
        "FOV": (7, [fx, fy, cx, cy, 0.9]),
    }[lens]
    rows = []
    for i in reversed(range(COUNT)):
        M = np.linalg.inv(poses()[i])
        q = Rotation.from_matrix(M[:3, :3]).as_quat(scalar_first=True)
        rows.append((i + 1, [*q, *M[:3, 3]], names[i], [(1.5, 2.5, 7)] * (i % 3)))
    if binary:
        data = struct.pack("<QIi2Q", 1, 3, number, *SIZE)
        (model / "cameras.bin").write_bytes(data + struct.pack(f"<{len(parameters)}d", *parameters))
        data = struct.pack("<Q", COUNT)
        for identifier, numbers, name, points in rows:
            data += struct.pack("<I7dI", identifier, *numbers, 3) + name.encode() + b"\0"
            data += struct.pack("<Q", len(points)) + b"".join(
                struct.pack("<2dq", *p) for p in points
            )
        (model / "images.bin").write_bytes(data)
        return folder
    words = " ".join(map(str, (3, lens, *SIZE, *parameters)))
    (model / "cameras.txt").write_text(f"# Camera list\n{words}\n")
    lines = [f"# Number of images: {COUNT}"]
    for identifier, numbers, name, points in rows:
        lines.append(" ".join(map(str, (identifier, *numbers, 3, name))))
        lines.append(" ".join(str(value) for point in points for value in point))
    (model / "images.txt").write_text("\n".join(lines) + "\n")
    return folder


def nerfstudio(folder: Path, each: bool = False, **more: object) -> Path:
    names = pictures(folder, [f"images/{i}.jpg" for i in range(COUNT)])
    camera: dict[str, object] = {"fl_x": K[0, 0], "fl_y": K[1, 1], "cx": K[0, 2], "cy": K[1, 2]}
    camera |= {"w": float(SIZE[0]), "h": SIZE[1], "camera_model": "OPENCV"}
    camera |= dict(zip(("k1", "k2", "p1", "p2"), LENS, strict=True))
    frames = []
    for name, pose in zip(names, poses(), strict=True):
        matrix = (pose @ np.diag([1.0, -1, -1, 1])).tolist()
        frames.append(
            {"file_path": f"./{name}", "transform_matrix": matrix} | (camera if each else {})
        )
    root = ({} if each else camera) | {"frames": frames} | more
    (folder / "transforms.json").write_text(json.dumps(root))
    return folder


def sevenscenes(folder: Path, intrinsics: bool = True) -> Path:
    for i, pose in enumerate(poses()):
        picture(folder / f"frame-{i:06d}.color.jpg")
        picture(folder / f"frame-{i:06d}.depth.png", 1500)
        np.savetxt(folder / f"frame-{i:06d}.pose.txt", pose)
    if intrinsics:
        np.savetxt(folder / "camera-intrinsics.txt", K)
    return folder


def tum(folder: Path) -> Path:
    """Pictures at 10 Hz, depth 8 ms later, poses at 100 Hz 3 ms off; the last second has none."""
    start = 1305031102.0
    rgb, depth, truth = ["# color"], ["# depth"], ["# timestamp tx ty tz qx qy qz qw"]
    for i, pose in enumerate(poses()):
        time = start + i / 10
        picture(folder / f"rgb/{time:.6f}.jpg")
        picture(folder / f"depth/{time:.6f}.png", 5000)
        rgb.append(f"{time:.6f} rgb/{time:.6f}.jpg")
        depth.append(f"{time + 0.008:.6f} depth/{time:.6f}.png")
        for step in (-1, 0, 1):
            turned = pose.copy()
            turned[:3, 3] += step
            q = Rotation.from_matrix(turned[:3, :3]).as_quat()
            numbers = " ".join(f"{value:.9f}" for value in (*turned[:3, 3], *q))
            truth.append(f"{time + 0.003 + 0.01 * step:.4f} {numbers}")
    rgb.append(f"{start + 9:.6f} rgb/{start:.6f}.jpg")
    for name, lines in (("rgb", rgb), ("depth", depth), ("groundtruth", truth)):
        (folder / f"{name}.txt").write_text("\n".join(lines) + "\n")
    (folder / "calibration.txt").write_text("50 51 31.5 24.25\n")
    return folder


def redwood(folder: Path) -> Path:
    lines = []
    for i, pose in enumerate(poses()):
        picture(folder / f"color/{i + 1}.jpg")
        picture(folder / f"depth/{i + 1}.png", 1500)
        lines.append(f"{i} {i} {i + 1}")
        lines += [" ".join(map(str, row)) for row in pose]
    (folder / "trajectory.log").write_text("\n".join(lines) + "\n")
    columns = {"width": SIZE[0], "height": SIZE[1], "intrinsic_matrix": K.T.ravel().tolist()}
    (folder / "intrinsic.json").write_text(json.dumps(columns))
    return folder


def scannet(folder: Path) -> Path:
    for name in ("pose", "intrinsic"):
        (folder / name).mkdir(parents=True)
    half = np.eye(4)
    half[:3, :3] = K
    half[:2, 2] -= 0.5
    for kind in ("color", "depth"):
        np.savetxt(folder / f"intrinsic/intrinsic_{kind}.txt", half)
    for i, pose in enumerate(poses()):
        picture(folder / f"color/{i}.jpg")
        picture(folder / f"depth/{i}.png", 1500)
        np.savetxt(folder / f"pose/{i}.txt", pose)
    return folder


def framelist(folder: Path) -> Path:
    names = pictures(folder, [f"photographs/{i}.jpg" for i in range(COUNT)])
    frames = [
        {"id": str(i), "picture": name, "resolution": SIZE, "K": K.tolist()}
        | {"world_from_camera": pose.tolist(), "distortion": LENS}
        for i, (name, pose) in enumerate(zip(names, poses(), strict=True))
    ]
    (folder / "frames.json").write_text(json.dumps(frames))
    return folder
