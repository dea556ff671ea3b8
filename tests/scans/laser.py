"""Laser scans written by others' libraries: LAS and LAZ by laspy, E57 by pye57."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest


def write_las(
    path: Path, points: np.ndarray, kind: int = 2, version: str = "1.2", **columns: Any
) -> Path:
    """Tenths of millimetres about the corner of the points."""
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=kind, version=version)
    header.scales, header.offsets = np.full(3, 1e-4), np.round(points.min(axis=0))
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    for name, values in columns.items():
        las[name] = values
    las.write(path)
    return path


def write_e57(
    path: Path,
    points: np.ndarray,
    rotation: Any = (1.0, 0.0, 0.0, 0.0),
    translation: Any = (0.0, 0.0, 0.0),
) -> Path:
    """One scan, seen from a place of its own."""
    pye57 = pytest.importorskip("pye57")
    columns = {f"cartesian{axis}": points[:, i] for i, axis in enumerate("XYZ")}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = pye57.E57(str(path), mode="w")
        file.write_scan_raw(columns, rotation=np.array(rotation), translation=np.array(translation))
        file.close()
    return path
