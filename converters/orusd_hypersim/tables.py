"""The CSV files of a scene, and those of all scenes."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from openrooms_usd import atomic
from openrooms_usd.rendering.reading import RenderedScene, RenderedView
from orusd_hypersim.cameras import projection, rays

SPLIT_FILE: Final = "analysis/metadata_images_split_scene_v1.csv"
CAMERAS_FILE: Final = "metadata_camera_parameters.csv"
SPLIT_HEADS: Final = tuple(
    (
        "scene_name camera_name frame_id included_in_public_release exclude_reason"
        " split_partition_name"
    ).split()
)
CAMERA_HEADS: Final = (
    "scene_name",
    "settings_output_img_height",
    "settings_output_img_width",
    "settings_units_info_meters_scale",
    "use_camera_physical",
    *(f"M_cam_from_uv_{row}{column}" for row in range(3) for column in range(3)),
    *(f"M_proj_{row}{column}" for row in range(4) for column in range(4)),
)
CAMERA: Final = "cam_00"
# An object of the table that no pixel has.
_NULL: Final = "_NULL_OBJECT"


def write_table(path: Path, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table.

    Raises:
        OutputError: It cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(heads)
    table.writerows(rows)
    atomic.write_text(path, text.getvalue())


def write_scene_tables(detail: Path, render: RenderedScene) -> None:
    """Write what is known of a scene: its unit, its camera, and the names of what pixels show."""
    write_table(detail / "metadata_cameras.csv", ("camera_name",), [(CAMERA,)])
    unit = ("meters_per_asset_unit", 1.0)
    write_table(detail / "metadata_scene.csv", ("parameter_name", "parameter_value"), [unit])
    named = render.legend("instance")
    nodes = range(1, max(named, default=0) + 1)
    rows = [
        (node, named.get(node, _NULL), node - 1 if node in named else -1, named.get(node, _NULL))
        for node in nodes
    ]
    heads = ("node_id", "node_name", "object_id", "object_name")
    write_table(detail / "metadata_nodes.csv", heads, rows)


def camera_row(scene: str, view: RenderedView) -> tuple[object, ...]:
    """The lens of a scene, as `CAMERA_HEADS` has it."""
    numbers = [*rays(view).ravel().tolist(), *projection(view).ravel().tolist()]
    return (scene, view.height, view.width, 1.0, False, *numbers)
