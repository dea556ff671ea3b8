"""What all rooms of a dataset show as COCO annotations: one file for each split."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from openrooms_usd import atomic, claims
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.coco import Annotations
from openrooms_usd.rendering.datasets import DatasetOptions, DatasetSummary, FinishedRoom

_LEDGER: Final = ".orusd.coco.sha256"


class CocoDataset:
    """``annotations/train.json`` and so on (docs/reference/annotations.md)."""

    takes: Final = "rooms"
    needs: Mapping[str, str] = MappingProxyType({})

    def write_rooms(
        self,
        rooms: Iterable[FinishedRoom],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write them by the ``taxonomy`` that is asked for; see `datasets.RoomsWriter`."""
        splits: dict[str, Annotations] = {}
        numbers: dict[str, int] = {}
        for room in rooms:
            progress(room.name, 0.5)
            if room.split not in splits:
                splits[room.split] = Annotations(options.taxonomy, numbers)
            for variant, render in sorted(room.renders.items()):
                place = f"renders/{room.name}/{variant}" if room.rows else room.name
                splits[room.split].add(render, f"{place}/")
        with claims.refilling(root, _LEDGER) as refill:
            for split, found in sorted(splits.items()):
                text = json.dumps(found.whole(), sort_keys=True, ensure_ascii=False)
                atomic.write_text(refill.folder / "annotations" / f"{split}.json", text + "\n")
        frames = {split: list(range(found.views)) for split, found in splits.items()}
        return DatasetSummary(root, frames, len(splits), {})
