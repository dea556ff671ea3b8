"""Views for torch: a dataset of them by number, and a loader (extra ``torch``).

What a training run sees depends only on the seed and the epoch. Every view has its own random
numbers, so runs with any number of workers see the same.
"""

from collections.abc import Sequence
from typing import Any, Final, Literal

import numpy as np

from openrooms_usd.loading.epochs import Epoch, EpochOrder
from openrooms_usd.loading.source import Shards, Source
from openrooms_usd.loading.streaming import ViewStream
from openrooms_usd.loading.tensors import Tensors, collate, tensors_of, torch
from openrooms_usd.loading.transforms import Transform

Start = Literal["spawn", "fork", "forkserver"]

HELD: Final = 64
"""Views of shards that are held back so that their order can be drawn."""


class ViewDataset(torch.utils.data.Dataset):  # type: ignore[misc]
    """Views as tensors, by number.

    Args:
        source: Where they come from.
        channels: Names of the table; those of every light end in ``_i``.
        transform: What is done to each; nothing by default.
        seed: Fixes what the transform draws, together with the epoch and the number of the view.
    """

    def __init__(
        self,
        source: Source,
        channels: Sequence[str],
        transform: Transform | None = None,
        seed: int = 0,
    ) -> None:
        self.source = source
        self.channels = tuple(channels)
        self.transform = transform
        self.seed = seed
        self.epoch = Epoch()

    def set_epoch(self, epoch: int) -> None:
        """Begin an epoch, from 0: transforms draw other numbers, and the order is another."""
        self.epoch.begin(epoch)

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, index: int) -> Tensors:
        """A view; see `openrooms_usd.loading.tensors.tensors_of`.

        Raises:
            InputError: It has no such channel, a file is missing or damaged, or the transform
                cannot be done.
        """
        if not -len(self) <= index < len(self):
            raise IndexError(f"there are {len(self)} views")
        place = int(index) % len(self)
        sample = self.source.read(place, self.channels)
        if self.transform is not None:
            rng = np.random.default_rng([self.seed, self.epoch.number, place])
            sample = self.transform(sample, rng)
        return tensors_of(sample)


def loader(
    source: Source | Shards,
    channels: Sequence[str],
    transform: Transform | None = None,
    *,
    batch: int = 1,
    workers: int = 0,
    seed: int = 0,
    shuffle: bool = True,
    drop_last: bool = False,
    rank: int = 0,
    replicas: int = 1,
    start: Start = "spawn",
    **others: Any,
) -> Any:
    """A ``torch.utils.data.DataLoader`` of views.

    Args:
        source: Where they come from, by `openrooms_usd.loading.opening.open_source`; shards are
            read from end to end (`openrooms_usd.loading.streaming`).
        channels: Names of the table; those of every light end in ``_i``.
        transform: What is done to each.
        batch: Views at once.
        workers: Processes that read; 0: this one.
        seed: Fixes the order and what transforms draw; ``loader.dataset.set_epoch`` begins the
            next epoch.
        shuffle: Whether the order is another in each epoch.
        drop_last: Whether a last batch that is not full is left out.
        rank: Which replica this is, of training on several.
        replicas: How many there are; each sees its share.
        start: How workers begin; ``spawn`` is safe whatever this process has done before.
        **others: For the DataLoader, such as ``pin_memory``.
    """
    shares = {"rank": rank, "replicas": replicas}
    dataset: ViewDataset | ViewStream
    if isinstance(source, Shards):
        order = None
        held = HELD if shuffle else 1
        dataset = ViewStream(source, channels, transform, seed, shuffle=held, **shares)
    else:
        dataset = ViewDataset(source, channels, transform, seed)
        order = EpochOrder(len(dataset), dataset.epoch, seed, shuffle=shuffle, **shares)
    working = {"multiprocessing_context": start, "persistent_workers": True} if workers else {}
    return torch.utils.data.DataLoader(
        dataset,
        batch_size=batch,
        sampler=order,
        num_workers=workers,
        collate_fn=collate,
        drop_last=drop_last,
        worker_init_fn=begin_worker,
        **working | others,
    )


def begin_worker(worker: int) -> None:
    """Let a process that reads read with one thread; what a fork left of others goes unused."""
    import OpenImageIO

    OpenImageIO.attribute("threads", 1)
    OpenImageIO.attribute("exr_threads", -1)
