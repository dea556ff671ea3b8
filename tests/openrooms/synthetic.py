"""A finished render made without a renderer: a floor and a wall, a lamp and a window."""

import json
from pathlib import Path

import numpy as np
import OpenImageIO

from openrooms_usd.channels import definition
from openrooms_usd.rendering.datasets import DatasetOptions, DatasetSummary
from openrooms_usd.rendering.reading import RenderedScene, read_render
from openrooms_usd.rendering.scene.lights import Gaussian, LightRecord
from orusd_openrooms import OpenRoomsDataset

LAMP, WINDOW, ELSEWHERE = 0, 1, 2
RADIANCE = [900.0, 800.0, 500.0]
GAUSSIANS = (
    Gaussian("sun", np.array([5000.0, 4500.0, 4000.0]), np.array([0.36, 0.8, 0.48]), 60.0),
    Gaussian("sky", np.array([90.0, 110.0, 150.0]), np.array([0.0, 0.6, 0.8]), 2.0),
    Gaussian("ground", np.array([30.0, 25.0, 20.0]), np.array([0.0, 0.8, -0.6]), 1.0),
)
FIT_ERROR = 0.125


def write_exr(path: Path, layers: dict[str, np.ndarray]) -> None:
    """Layers as ``<layer>.<part>``; the empty name for plain R, G, B. No compression: fast."""
    names, planes = [], []
    for name, pixels in layers.items():
        prefix = f"{name}." if name else ""
        names += [prefix + part for part in (definition(name).components if name else "RGB")]
        planes.append(pixels.astype(np.float32))
    joined = np.ascontiguousarray(np.concatenate(planes, axis=-1))
    height, width = joined.shape[:2]
    spec = OpenImageIO.ImageSpec(width, height, len(names), OpenImageIO.FLOAT)
    spec.channelnames = tuple(names)
    spec.attribute("compression", "none")
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(joined) and output.close()


def look_at(origin: np.ndarray, target: np.ndarray) -> np.ndarray:
    """(4, 4) from the OpenCV camera frame to the world, Z up."""
    forward = (target - origin) / np.linalg.norm(target - origin)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    matrix[:3, 3] = origin
    return matrix


def turned(angle: float, center: list[float]) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.eye(4)
    matrix[:3, :3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    matrix[:3, 3] = center
    return matrix


# As the renderer has them: its own writing of them goes into the manifest.
LIGHTS = [
    LightRecord(
        ELSEWHERE, "elsewhere", "", "elsewhere", True, np.eye(4), np.zeros(3), np.ones(3), 0.0
    ),
    LightRecord(
        LAMP,
        "lamp",
        "/World/Furniture/lamp",
        "lamp",
        True,
        turned(0.5, [0.3, 2.0, 2.4]),
        np.array([0.3, 0.5, 0.2]),
        np.array(RADIANCE),
        800.0,
        kelvin=3000.0,
        instance=3,
    ),
    LightRecord(
        WINDOW,
        "window",
        "/World/Room/W",
        "opening",
        True,
        np.array([[-1.0, 0, 0, -0.8], [0, 0, 1, 4.0], [0, 1, 0, 1.5], [0, 0, 0, 1]]),
        np.array([1.2, 1.4, 0.0]),
        np.array([500.0, 600.0, 700.0]),
        3000.0,
        gaussians=GAUSSIANS,
        fit_error=FIT_ERROR,
    ),
]


def cast(K: np.ndarray, pose: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Depth and world normals of the floor z = 0 and the wall y = 4; 0 where the window is."""
    width, height = size
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.linalg.inv(K).T @ pose[:3, :3].T
    with np.errstate(divide="ignore"):
        floor, wall = -pose[2, 3] / rays[..., 2], (4.0 - pose[1, 3]) / rays[..., 1]
    floor, wall = (np.where(t > 0, t, np.inf) for t in (floor, wall))
    depth = np.minimum(floor, wall)
    normals = np.where((floor < wall)[..., None], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0])
    points = pose[:3, 3] + depth[..., None] * rays
    window = (wall < floor) & (np.abs(points[..., 0] + 0.8) < 0.6)
    window &= np.abs(points[..., 2] - 1.5) < 0.7
    return np.where(window, 0.0, depth), np.where(window[..., None], 0.0, normals)


def write_view(
    folder: Path, pose: np.ndarray, size: tuple[int, int], grid: tuple[int, int], seed: int
) -> dict[str, object]:
    width, height = size
    rng = np.random.default_rng(seed)
    K = np.array([[0.9 * width, 0, width / 2], [0, 0.9 * width, height / 2], [0, 0, 1.0]])
    depth, normals = cast(K, pose, size)
    seen = (depth > 0)[..., None]
    camera_normals = normals @ pose[:3, :3] * [1.0, -1.0, -1.0]

    def light(scale: float) -> np.ndarray:
        return np.exp(rng.normal(np.log(scale), 1.0, (height, width, 3)))

    labels = np.where(normals[..., 2:] > 0, 1, 2) * seen
    bulb = np.zeros_like(seen)
    bulb[:3, :5] = seen[:3, :5]
    visibility = rng.random((height, width, 3))
    unoccluded = {LAMP: light(300.0), WINDOW: light(800.0)}
    folder.mkdir(parents=True)
    write_exr(
        folder / "channels.exr",
        {
            "radiance": light(100.0),
            "depth": depth[..., None],
            "normal_camera": camera_normals,
            "base_color": rng.random((height, width, 3)) * seen,
            "roughness": rng.random((height, width, 1)) * seen,
            "metallic": rng.random((height, width, 1)) * seen,
            "semantic": np.where(labels == 1, 44, 43) * seen,
            "instance": labels,
            "material": np.where(labels == 1, 0, 3) * seen,
            "emission_mask": bulb * 1.0,
            "valid": seen * 1.0,
            "friction": 0.5 * seen,
            "irradiance": light(400.0),
            "irradiance_direct": light(200.0),
        },
    )
    write_exr(
        folder / "lights.exr",
        {
            f"{name}_{number}": value
            for number, free in unoccluded.items()
            for name, value in (
                ("unoccluded", free),
                ("visibility", visibility),
                ("direct", free * visibility),
                ("mask", ~seen * 1.0 if number == WINDOW else bulb * 1.0),
            )
        },
    )
    rows, columns = grid
    for name in ("environment", "environment_direct"):
        cells = rng.random((rows, columns, 16, 32, 3), np.float32) * 500
        tiles = cells.transpose(0, 2, 1, 3, 4).reshape(rows * 16, columns * 32, 3)
        write_exr(folder / f"{name}.exr", {"": tiles})
    np.save(folder / "environment_sg.npy", rng.random((rows, columns, 12, 6), np.float32))
    return {"resolution": list(size), "K": K.tolist(), "world_from_camera": pose.tolist()}


def random_pose(rng: np.random.Generator, spread: float = 1.0) -> np.ndarray:
    """A pose of any direction, right-handed."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    matrix[:3, 0] *= np.linalg.det(matrix[:3, :3])
    matrix[:3, 3] = rng.normal(size=3) * spread
    return matrix


def make_render(
    folder: Path,
    size: tuple[int, int] = (64, 48),
    grid: tuple[int, int] = (12, 16),
    views: int = 2,
    seed: int = 0,
) -> RenderedScene:
    poses = [
        look_at(np.array([0.4 * k - 0.3, 0.0, 1.6]), np.array([-0.3, 4.0, 1.1 + 0.1 * k]))
        for k in range(views)
    ]
    entries = {
        f"view_{k}": write_view(folder / f"view_{k}", pose, size, grid, seed + k)
        for k, pose in enumerate(poses)
    }
    legend = {"instance": {"1": "/World/Room/Floor", "2": "/World/Room/Walls/Wall_0"}}
    lights = [light.as_dict() for light in LIGHTS]
    manifest = {
        "views": entries,
        "lights": lights,
        "legend": legend,
        "channels": {},
        "generator": "openrooms_usd 0.2.0",
    }
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    return read_render(folder)


def write_dataset(renders: list[RenderedScene], root: Path, **options: object) -> DatasetSummary:
    return OpenRoomsDataset().write(renders, root, DatasetOptions(**options))
