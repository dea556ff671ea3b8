"""Photographs of a small room, where they were taken from, and points of its floor."""

import json
from pathlib import Path

import numpy as np

SCENE = "scene0000_00"
SIZE = (32, 24)
K = np.array([[30.0, 0, 16], [0, 30.0, 12], [0, 0, 1]])
LEVEL = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def floor_points(step: float = 0.2) -> np.ndarray:
    """(N, 3) points of a floor."""
    x, y = np.meshgrid(np.arange(0, 4, step), np.arange(0, 3, step), indexing="ij")
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], -1)


def pose(i: int) -> np.ndarray:
    """world_from_camera of a photograph that looks along y."""
    M = np.eye(4)
    M[:3, :3], M[:3, 3] = LEVEL, [1 + 0.1 * i, 0.2 * i, 1.2]
    return M


def write_frames(path: Path) -> None:
    """Cameras of two photographs."""
    frames = [
        {
            "id": str(i), "picture": f"color/{i}.jpg", "resolution": list(SIZE), "K": K.tolist(),
            "world_from_camera": pose(i).tolist(),
        }
        for i in range(2)
    ]  # fmt: skip
    path.write_text(json.dumps(frames))
