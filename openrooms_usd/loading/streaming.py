"""Views of shards for torch, read from end to end (extra ``torch``).

Replicas and their workers share the shards out. Which views there are, and what their transforms
draw, is the same for any number of workers; the order in which they come is not.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from openrooms_usd.loading.epochs import Epoch, check_rank
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.source import Shards
from openrooms_usd.loading.tensors import Tensors, tensors_of, torch
from openrooms_usd.loading.transforms import Transform


class ViewStream(torch.utils.data.IterableDataset):  # type: ignore[misc]
    """Views as tensors, as they come.

    Args:
        shards: Where they come from.
        channels: Names of the table; those of every light end in ``_i``.
        transform: What is done to each; nothing by default.
        seed: Fixes the order and what transforms draw, together with the epoch.
        shuffle: How many views are held back so that their order can be drawn; 1 keeps the order
            of the shards, which is drawn else, too.
        rank: Which replica this is.
        replicas: How many there are; shards that cannot be shared out evenly make some read more.

    Raises:
        InputError: There is no such replica.
    """

    def __init__(
        self,
        shards: Shards,
        channels: Sequence[str],
        transform: Transform | None = None,
        seed: int = 0,
        *,
        shuffle: int = 64,
        rank: int = 0,
        replicas: int = 1,
    ) -> None:
        check_rank(rank, replicas)
        self.shards, self.channels, self.transform = shards, tuple(channels), transform
        self.seed, self.shuffle, self.rank, self.replicas = seed, shuffle, rank, replicas
        self.epoch = Epoch()

    def set_epoch(self, epoch: int) -> None:
        """Begin an epoch, from 0: transforms draw other numbers, and the order is another."""
        self.epoch.begin(epoch)

    def __iter__(self) -> Iterator[Tensors]:
        info = torch.utils.data.get_worker_info()
        worker, workers = (0, 1) if info is None else (info.id, info.num_workers)
        share, shares = self.rank * workers + worker, self.replicas * workers
        numbers = np.arange(len(self.shards.names))
        drawn = [self.seed, self.epoch.number]
        if self.shuffle > 1:
            np.random.default_rng(drawn).shuffle(numbers)
        views = (view for number in numbers[share::shares] for view in self._views(int(number)))
        return map(
            tensors_of, _shuffle(views, self.shuffle, np.random.default_rng([*drawn, share]))
        )

    def _views(self, number: int) -> Iterator[Sample]:
        """The views of a shard, transformed."""
        views = self.shards.stream(self.shards.names[number], self.channels)
        for place, sample in enumerate(views):
            rng = np.random.default_rng([self.seed, self.epoch.number, number, place])
            yield sample if self.transform is None else self.transform(sample, rng)


def _shuffle(views: Iterator[Sample], most: int, rng: np.random.Generator) -> Iterator[Sample]:
    """The same views in another order: one of the last few, whichever is drawn."""
    held: list[Sample] = []
    for view in views:
        held.append(view)
        if len(held) >= max(most, 1):
            yield held.pop(int(rng.integers(len(held))))
    while held:
        yield held.pop(int(rng.integers(len(held))) if most > 1 else 0)
