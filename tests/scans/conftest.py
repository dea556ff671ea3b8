"""A writer of RoomPlan exports: the JSON that the phone would write of a room that is known."""

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest


class Scanner:
    """Writes rooms as CapturedRoom JSON, seen from a frame of its own.

    Rooms are given Z up with the floor at 0. The source's frame is Y up, turned by
    ``heading`` about the vertical and moved by ``origin``, in double precision.
    """

    def __init__(self, folder: Path, heading: float = 37.0, origin: Any = (3.0, -1.5, 8.0)) -> None:
        self.folder = folder
        c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
        y_up = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], dtype=float)  # (x, y, z) -> (x, z, -y)
        self.rotation = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ y_up
        self.origin = np.asarray(origin, dtype=float)

    def source(self, points: Any) -> np.ndarray:
        """Points of the room in the source's frame."""
        return np.asarray(points, dtype=float) @ self.rotation.T + self.origin

    def transform(self, center: Any, axes: Any) -> list[float]:
        """16 numbers, column by column, of a local frame whose axes are given in the room."""
        M = np.eye(4)
        M[:3, :3] = self.rotation @ np.array(axes, dtype=float).T
        M[:3, 3] = self.source(center)
        return [float(x) for x in M.T.ravel()]

    def surface(self, kind: str, a: Any, b: Any, low: float, high: float, **more: Any) -> dict:
        """A rectangle over the segment a b of the plan."""
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        along = (b - a) / np.linalg.norm(b - a)
        axes = [[*along, 0], [0, 0, 1], [along[1], -along[0], 0]]
        center = [*(0.5 * (a + b)), 0.5 * (low + high)]
        return {
            "identifier": f"{kind}-{a.tolist()}-{b.tolist()}",
            "category": {kind: {}},
            "confidence": {"high": {}},
            "dimensions": [float(np.linalg.norm(b - a)), high - low, 0],
            "transform": self.transform(center, axes),
            "parentIdentifier": None,
            "completedEdges": [],
            "curve": None,
            "polygonCorners": [],
            "story": 0,
        } | more

    def floor(self, corners: Any) -> dict:
        """A floor whose own frame is turned and lies anywhere on it."""
        corners = np.asarray(corners, dtype=float)
        center = np.array([*corners.mean(axis=0), 0.0])
        axes = np.array([[0.6, 0.8, 0], [0.8, -0.6, 0], [0, 0, -1]])
        local = (np.column_stack([corners, np.zeros(len(corners))]) - center) @ axes.T
        return {
            "identifier": "floor",
            "category": {"floor": {}},
            "confidence": {"high": {}},
            "dimensions": [*np.ptp(local[:, :2], axis=0).tolist(), 0],
            "transform": self.transform(center, axes),
            "polygonCorners": local.tolist(),
        }

    def box(self, category: str, center: Any, size: Any, yaw: float, **more: Any) -> dict:
        """An object whose front looks along -Y at yaw 0 (width, depth, height)."""
        c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
        width, depth, height = size
        right, front = np.array([c, s, 0]), np.array([s, -c, 0])
        return {
            "identifier": f"{category}-{center}",
            "category": {category: {}},
            "confidence": {"medium": {}},
            "dimensions": [width, height, depth],
            "transform": self.transform(center, [right, [0, 0, 1], front]),
        } | more

    def room(self, corners: Any, height: float, **more: Any) -> dict:
        """A whole export with one wall over each edge."""
        ring = [*corners, corners[0]]
        walls = [self.surface("wall", a, b, 0.0, height) for a, b in pairwise(ring)]
        return {
            "version": 2,
            "story": 0,
            "coreModel": "A" * 1000,
            "sections": [],
            "walls": walls,
            "floors": [self.floor(corners)],
            "doors": [],
            "windows": [],
            "openings": [],
            "objects": [],
        } | more

    def write(self, data: Any, name: str = "Room.json") -> Path:
        """Write it as the app does: one line."""
        path = self.folder / name
        path.write_text(json.dumps(data), encoding="utf-8")
        return path


@pytest.fixture
def scanner(tmp_path: Path) -> Scanner:
    return Scanner(tmp_path)


@pytest.fixture
def any_scan_will_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """Points that show no room are imported too."""
    monkeypatch.setattr("openrooms_usd.importing.captures.check_scan", lambda *_: "")
