"""The tables: our pictures before and after, photographs measured alike, and what is published."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.realism.features import features
from benchmarks.realism.published import AMPLITUDE_SLOPE, NYU40_PER_CENT, OBJECTS_A_PICTURE
from benchmarks.realism.views import (
    class_shares,
    geometry,
    pictures,
    read,
    rendered,
    total_variation,
)
from benchmarks.report import table

# All pictures are compared at this width, pixels.
WIDTH: Final = 480
# The least deviation of a feature among photographs, as a share of its mean: few photographs of one
# room agree by chance.
_LEAST_DEVIATION_SHARE: Final = 0.05

Rows = dict[str, list[float]]


def measured(folder: Path) -> Rows:
    """Features of all pictures below a folder, by name."""
    return _columns([features(read(path, WIDTH)) for path in pictures(folder)])


def seen(folder: Path) -> tuple[Rows, dict[str, float]]:
    """Geometry of all renders below a folder by name, and their classes in per cent."""
    views = list(rendered(folder))
    return _columns([geometry(view) for view, _ in views]), class_shares(views)


def _columns(rows: Sequence[Mapping[str, float]]) -> Rows:
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}


def picture_rows(sets: Mapping[str, Rows], photographs: Rows) -> list[list[Any]]:
    """One row for each feature: mean and deviation of every set, and how far from photographs.

    Distances are between means, in deviations of the photographs.
    """
    rows: list[list[Any]] = []
    for name in next(iter(sets.values())):
        row: list[Any] = [name, *(_spread(columns[name]) for columns in sets.values())]
        if photographs:
            row.append(_spread(photographs[name]))
            row += [distance(columns[name], photographs[name]) for columns in sets.values()]
        rows.append(row)
    return rows


def distance(ours: Sequence[float], theirs: Sequence[float]) -> float:
    """Between the means of two sets, in deviations of the second."""
    mean = float(np.mean(theirs))
    deviation = max(float(np.std(theirs)), _LEAST_DEVIATION_SHARE * abs(mean), 1e-6)
    return abs(float(np.mean(ours)) - mean) / deviation


def _spread(values: Sequence[float]) -> str:
    return f"{np.mean(values):.3g} ± {np.std(values):.2g}"


def class_rows(sets: Mapping[str, dict[str, float]]) -> list[list[Any]]:
    """Shares of pixels by class, per cent, beside those of NYU Depth V2; the largest first."""
    names = sorted(NYU40_PER_CENT, key=lambda name: -NYU40_PER_CENT[name])
    rows: list[list[Any]] = [
        [name, *(f"{shares.get(name, 0.0):.1f}" for shares in sets.values()), NYU40_PER_CENT[name]]
        for name in names
    ]
    far = [f"{total_variation(shares, NYU40_PER_CENT):.2f}" for shares in sets.values()]
    return [*rows, ["total variation", *far, 0]]


def markdown(
    sets: Mapping[str, tuple[Rows, Rows, dict[str, float]]], photographs: Rows, count: int
) -> str:
    """All tables.

    Args:
        sets: Features, geometry and classes of each set of renders, by its title.
        photographs: Features of photographs; empty where there are none.
        count: How many photographs.
    """
    titles = list(sets)
    beside = [f"{count} photographs", *(f"{title}: distance" for title in titles)]
    first = table(
        ["picture", *titles, *(beside if photographs else ())],
        picture_rows({title: row[0] for title, row in sets.items()}, photographs),
    )
    second = table(
        ["geometry", *titles],
        picture_rows({title: row[1] for title, row in sets.items()}, {}),
    )
    third = table(
        ["class, % of pixels", *titles, "NYU Depth V2"],
        class_rows({title: row[2] for title, row in sets.items()}),
    )
    slope, steep, flat = (2.0 * value for value in AMPLITUDE_SLOPE)
    objects = ", ".join(f"{name} {value}" for name, value in OBJECTS_A_PICTURE.items())
    return (
        f"{first}\n\nPublished slope of power: {slope:g} ({steep:g} to {flat:g}).\n\n{second}\n\n"
        f"Published objects a picture: {objects}.\n\n{third}"
    )
