"""Which objects of the library are shown."""

from collections.abc import Sequence
from dataclasses import dataclass

from openrooms_usd.furniture import CATEGORIES, Size, category, styles
from openrooms_usd.furniture.record import Support


@dataclass(frozen=True)
class Exhibit:
    """An object to be shown.

    Attributes:
        category: What it is.
        style: How it is built.
        size: Its usual width, depth and height, metres.
        support: What carries it.
        level: Height of its base above the floor where it hangs on a wall, metres.
        emits: Whether it is a lamp.
    """

    category: str
    style: str
    size: Size
    support: Support
    level: float
    emits: bool

    @property
    def name(self) -> str:
        """Its prim name."""
        return f"{self.category}__{self.style}"


def exhibits(categories: Sequence[str] = (), *, every_style: bool = False) -> list[Exhibit]:
    """The exhibits of some categories, in the order of their names.

    Args:
        categories: Which; all where empty.
        every_style: Every style of each, not only the first that suits its usual size.

    Raises:
        InputError: The library has no such category.
    """
    names = sorted(set(categories) or CATEGORIES)
    return [
        _exhibit(name, style)
        for name in names
        for style in (category(name).styles if every_style else styles(name)[:1])
    ]


def _exhibit(name: str, style: str) -> Exhibit:
    spec = category(name)
    size = spec.styles[style].size or spec.size
    return Exhibit(name, style, size, spec.support, spec.mount_height, spec.emits)
