"""One table of all views of a dataset, as Parquet: what a training run chooses its views by."""

import json
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from openrooms_usd import atomic, claims
from openrooms_usd.errors import InputError, writing
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.datasets import DatasetOptions, DatasetSummary, FinishedRoom

FILE: Final = "views.parquet"
# A few megabytes each: a million views are never held at once.
_ROWS_IN_GROUP: Final = 5_000

Row = dict[str, Any]


class ParquetIndex:
    """``views.parquet``: a row for each view (docs/howto/datasets.md)."""

    takes: Final = "rooms"
    needs: Mapping[str, str] = MappingProxyType({"pyarrow": "parquet"})

    def write_rooms(
        self,
        rooms: Iterable[FinishedRoom],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write the table, for which rooms need ``rows``; see `rendering.datasets.RoomsWriter`."""
        import pyarrow.parquet

        rows, counts = _rows(rooms, progress), dict[str, list[int]]()
        schema = _schema()
        with (
            claims.output(root / FILE),
            atomic.replacing(root / FILE) as beside,
            writing(root / FILE),
            pyarrow.parquet.ParquetWriter(beside, schema, compression="zstd") as file,
        ):
            while group := list(islice(rows, _ROWS_IN_GROUP)):
                file.write_table(pyarrow.Table.from_pylist(group, schema=schema))
                for row in group:
                    counts.setdefault(row["split"], []).append(row["view"])
        return DatasetSummary(root, counts, 1, {})


def _rows(rooms: Iterable[FinishedRoom], progress: Progress) -> Iterator[Row]:
    for room in rooms:
        progress(room.name, 0.5)
        if not room.rows:
            raise InputError(
                "a single render has no index",
                place=room.name,
                remedy="add parquet to the outputs of a dataset.yaml",
            )
        yield from (_row(room, said) for said in room.rows.values())


def _row(room: FinishedRoom, said: Mapping[str, Any]) -> Row:
    """A view as the columns of `_schema` have it."""
    width, height = said["resolution"]
    return {
        "unit": said["unit"],
        "room": room.name,
        "number": room.number,
        "variant": said["variant"],
        "view": int(said["unit"].rpartition("_")[2]),
        "split": said["split"],
        "source": json.dumps(said["source"], sort_keys=True),
        "folder": said["folder"],
        "width": width,
        "height": height,
        "K": [number for row in said["K"] for number in row],
        "world_from_camera": [number for row in said["world_from_camera"] for number in row],
        "instances": said.get("instances"),
        "lights": said.get("lights"),
        "classes": len(said.get("pixels") or ()),
        "pixels": sorted((said.get("pixels") or {}).items()),
        "errors": sorted(said["errors"].items()),
        "measures": sorted((n, float(v)) for n, v in said["quality"]["measures"].items()),
        "faults": said["quality"]["faults"],
        "files": sorted(said["files"].items()),
    }


def _schema() -> Any:
    import pyarrow as pa

    numbers, words = pa.map_(pa.string(), pa.float64()), pa.map_(pa.string(), pa.string())
    return pa.schema(
        {
            "unit": pa.string(),
            "room": pa.string(),
            "number": pa.int64(),
            "variant": pa.string(),
            "view": pa.int32(),
            "split": pa.string(),
            "source": pa.string(),
            "folder": pa.string(),
            "width": pa.int32(),
            "height": pa.int32(),
            # Row by row, as the manifest has them.
            "K": pa.list_(pa.float64(), 9),
            "world_from_camera": pa.list_(pa.float64(), 16),
            "instances": pa.int32(),
            "lights": pa.int32(),
            "classes": pa.int32(),
            "pixels": pa.map_(pa.string(), pa.int64()),
            "errors": numbers,
            "measures": numbers,
            "faults": pa.list_(pa.string()),
            "files": words,
        }
    )
