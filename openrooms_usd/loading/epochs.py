"""Which epoch it is, and the order of views in it: the same for any number of workers."""

from collections.abc import Iterator

import numpy as np

from openrooms_usd.errors import InputError
from openrooms_usd.loading.tensors import torch


class Epoch:
    """The number of an epoch, from 0, which processes that read share."""

    def __init__(self) -> None:
        # Shared, so that workers which live longer than an epoch know of the next one.
        self._number = torch.zeros((), dtype=torch.int64).share_memory_()

    @property
    def number(self) -> int:
        """Which it is."""
        return int(self._number)

    def begin(self, number: int) -> None:
        """Begin another one."""
        self._number.fill_(number)


class EpochOrder:
    """The order of views by number in an epoch, or a replica's share of it.

    It is that of ``DistributedSampler``: each replica has as many views, some twice where they
    cannot be shared out evenly.

    Args:
        count: How many views there are.
        epoch: Which it is.
        seed: Fixes the order, together with the epoch.
        shuffle: Whether each epoch has another order; else that of the source.
        rank: Which replica this is.
        replicas: How many there are.

    Raises:
        InputError: There is no such replica.
    """

    def __init__(
        self, count: int, epoch: Epoch, seed: int, *, shuffle: bool, rank: int, replicas: int
    ) -> None:
        check_rank(rank, replicas)
        self.count, self.epoch, self.seed, self.shuffle = count, epoch, seed, shuffle
        self.rank, self.replicas = rank, replicas

    def __len__(self) -> int:
        return -(-self.count // self.replicas)

    def __iter__(self) -> Iterator[int]:
        order = np.arange(self.count)
        if self.shuffle:
            np.random.default_rng([self.seed, self.epoch.number]).shuffle(order)
        yield from np.resize(order, len(self) * self.replicas)[self.rank :: self.replicas].tolist()


def check_rank(rank: int, replicas: int) -> None:
    """See that there is a replica.

    Raises:
        InputError: There is none.
    """
    if not 0 <= rank < replicas:
        raise InputError(f"there is no replica {rank} of {replicas}", remedy="count from 0")
