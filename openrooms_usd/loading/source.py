"""Where views come from: the contract of sources, and of the forms that open them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from openrooms_usd.errors import InputError
from openrooms_usd.loading.files import Files
from openrooms_usd.loading.sample import Sample


@runtime_checkable
class Source(Protocol):
    """Views by number. It can be pickled, and holds nothing open between two views."""

    def __len__(self) -> int:
        """How many there are."""
        ...

    def read(self, index: int, channels: Sequence[str]) -> Sample:
        """One of them.

        Args:
            index: From 0.
            channels: Names of the table; those of every light end in ``_i``.

        Raises:
            InputError: It has no such channel, or a file is missing or damaged.
        """
        ...


@runtime_checkable
class Shards(Protocol):
    """Views that are read from end to end, in files of many. It can be pickled.

    Attributes:
        names: Of the files.
    """

    @property
    def names(self) -> Sequence[str]:
        """The shards."""
        ...

    def __len__(self) -> int:
        """How many views there are, before any are chosen."""
        ...

    def stream(self, name: str, channels: Sequence[str]) -> Iterator[Sample]:
        """The views of a shard, in its order.

        Args:
            name: One of ``names``.
            channels: As of `Source.read`.

        Raises:
            InputError: It cannot be read, or a view has no such channel.
        """
        ...


@dataclass(frozen=True)
class ViewSelection:
    """Which views of a dataset are wanted; what is empty admits all.

    Attributes:
        splits: Such as ``train``.
        variants: Such as ``mainDiffMat``.
        rooms: Their names.
        views: Their names.
    """

    splits: tuple[str, ...] = ()
    variants: tuple[str, ...] = ()
    rooms: tuple[str, ...] = ()
    views: tuple[str, ...] = ()

    def admits(self, split: str, variant: str, room: str, view: str) -> bool:
        """Whether a view is wanted."""
        wanted = ((self.splits, split), (self.variants, variant), (self.rooms, room))
        return all(not names or name in names for names, name in (*wanted, (self.views, view)))


class Form(Protocol):
    """Opens what lies in a form; an entry point ``openrooms_usd.sources``.

    Attributes:
        options: What may be asked of it, for people, by name.
    """

    options: Mapping[str, str]

    def open(
        self, files: Files, selection: ViewSelection, options: Mapping[str, str]
    ) -> Source | Shards:
        """The views that are there.

        Args:
            files: Where they lie.
            selection: Which of them are wanted.
            options: What is asked, all of it declared.

        Raises:
            InputError: It is not in this form.
        """
        ...


def refuse_nothing(count: int, files: Files, selection: ViewSelection) -> None:
    """See that there are views.

    Raises:
        InputError: There are none.
    """
    if not count:
        raise InputError(
            f"there is no view of {selection}"
            if selection != ViewSelection()
            else "there is no view",
            place=files,
            remedy="check the path, and the names of splits, variants, rooms and views",
        )
