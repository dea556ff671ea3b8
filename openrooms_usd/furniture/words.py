"""What the words of captures mean: what the library builds for a thing that is called so.

The words stand in the records of the categories, in the spelling of NYU40, ScanNet's raw names,
S3DIS, SUN RGB-D, ARKitScenes, Matterport's mpcat40, RoomPlan and ShapeNet. A compound that none of
them has is what its last noun is (a "wooden stool" is a stool), as in all English compounds, but
for nouns that name a part or a shape there (`_NO_HEADS`). What no record claims has no counterpart
in the library, above all the bins of class lists: "otherfurniture", "clutter", "object".
"""

import re
from collections.abc import Iterator, Sequence
from typing import Final, Literal, NamedTuple

from openrooms_usd.codedigest import remembered
from openrooms_usd.furniture.others import OTHERS
from openrooms_usd.furniture.registry import BUILT, records
from openrooms_usd.names import SHELL

Choices = tuple[tuple[str, ...], ...]


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


# Parts of the building besides the categories of the shell: a scan's walls have them already.
_BUILDING: Final = _set(
    "baseboard door_frame doorframe doorway molding paneling partition roof wainscoting "
    "wallpaper window_frame window_sill windowsill"
)
# What is not part of a room, or of any thing.
_NOTHING: Final = _set("artifact child human man people person reflection remove woman")
# Nouns that are other things at the end of a compound: handrails are bars, skis stand in racks.
_NO_HEADS: Final = _set(
    "art artwork bar basin bath blind board commode console display drawer dryer flower "
    "island map pot rack range screen step storage tap towel tree tub"
)
# After these the noun has been said: "counter top for sink", "stack of chairs".
_JOINTS: Final = _set("above behind for in of on under w with")

# Words for lamps of any kind, which are told apart by where they begin above the floor, metres.
LAMP: Final = "lamp"
_LAMPS: Final = frozenset((LAMP, "light", "lighting"))
_HANGS_M: Final = 1.5
_STANDS_M: Final = 0.1
# What hangs on walls alone begins above this, metres.
_HUNG_M: Final = 0.6

# What else a broad word means, without anything that would tell.
_BROAD: Final[dict[str, tuple[str, ...]]] = {
    "cabinet": ("kitchen_cabinet",),
    "chair": ("armchair", "office_chair"),
    "storage": ("kitchen_cabinet",),
    "table": ("coffee_table", "side_table"),
    "tv_monitor": ("monitor",),
}
BROAD: Final = frozenset((*_BROAD, LAMP))
"""Categories and words that others are kinds of."""

# What stands for a category where its own pieces are never of the size that was found: the nearest
# in use and shape.
_KIN: Final[dict[str, tuple[str, ...]]] = {
    "armchair": ("chair", "sofa"),
    "basket": ("trash_bin",),
    "bench": ("stool", "coffee_table"),
    "bookshelf": ("cabinet",),
    "cabinet": ("wardrobe", "dresser", "side_table"),
    "chair": ("stool",),
    "coffee_table": ("table", "side_table"),
    "counter": ("cabinet", "kitchen_cabinet"),
    "crib": ("bed",),
    "desk": ("table",),
    "dresser": ("cabinet", "side_table"),
    "file_cabinet": ("cabinet",),
    "floor_lamp": ("table_lamp",),
    "kitchen_cabinet": ("cabinet",),
    "microwave": ("oven",),
    "monitor": ("television",),
    "night_stand": ("side_table", "cabinet"),
    "office_chair": ("chair", "armchair"),
    "oven": ("stove", "microwave"),
    "ottoman": ("stool",),
    "picture": ("whiteboard",),
    "rack": ("bookshelf",),
    "side_table": ("night_stand", "cabinet", "dresser", "table"),
    "sofa": ("armchair",),
    "stool": ("side_table",),
    "stove": ("oven",),
    "table": ("desk",),
    "table_lamp": ("floor_lamp",),
    "television": ("monitor",),
    "trash_bin": ("basket",),
    "wardrobe": ("cabinet",),
    "whiteboard": ("picture",),
}


class Meaning(NamedTuple):
    """What a word means.

    Attributes:
        kind: A ``thing``, a part of the ``building``, or ``nothing`` that a room has.
        choices: Categories of the library that may stand for a thing, in groups of equals, the
            better groups first; none where the library has no counterpart.
    """

    kind: Literal["thing", "building", "nothing"]
    choices: Choices = ()


def plain(word: str) -> str:
    """A word in lower case with underscores: ``washer_dryer`` for ``washerDryer``.

    It is a valid prim name, also where nothing of the word is left.
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", word)
    name = re.sub(r"[^a-z0-9]+", "_", apart.lower()).strip("_")
    return name if name[:1].isalpha() else f"thing_{name}".rstrip("_")


@remembered
def library_words() -> dict[str, str]:
    """The library's category by a word in plain form: its own name, and other words."""
    built = {name: told for name, told in records() if name in BUILT}
    words = {word: name for name, told in built.items() for word in told.words.split()}
    return {**{name: name for name in built}, **words}


def meaning(words: Sequence[str], above_floor: float) -> Meaning:
    """What a thing is.

    Args:
        words: For it, its own name first, then what is said of it besides, such as its WordNet
            synset and its class. The first that means something counts.
        above_floor: How high it begins above the floor, metres.
    """
    known = (named for word in words if (named := _match_word(word)) is not None)
    found, name = next(known, ("", ""))
    if name in _BUILDING or name in SHELL:
        return Meaning("building")
    if found in _NOTHING:
        return Meaning("nothing")
    if found in _LAMPS:
        return Meaning("thing", lamps(above_floor))
    if name not in BUILT or name == "box":
        return Meaning("thing")
    first = tuple(
        kind
        for kind in (name, *_BROAD.get(found, ()))
        if kind != "kitchen_cabinet" or kind == name or above_floor > _HUNG_M
    )
    kin = tuple((kind,) for kind in _KIN.get(name, ()) if kind not in first)
    return Meaning("thing", (first, *kin))


def category_of(word: str, above_floor: float) -> str | None:
    """The likeliest of the library's categories for a word; None where it has none.

    Args:
        word: Of a capture.
        above_floor: How high the thing begins above the floor, metres.
    """
    found, name = _match_word(word) or ("", "")
    if found in _LAMPS:
        return lamps(above_floor)[0][0]
    return name if name in BUILT else None


def spelled(word: str) -> str | None:
    """The category that a word names, of the library or of what captures bring; None of none."""
    found, name = _match_word(word) or ("", "")
    if found in _LAMPS:
        return LAMP
    return None if found in _NOTHING else name or None


def lamps(above_floor: float) -> Choices:
    """What a lamp may be that begins so high above the floor, metres."""
    if above_floor > _HANGS_M:
        return (("ceiling_lamp", "wall_lamp"),)
    if above_floor < _STANDS_M:
        return (("floor_lamp",), ("table_lamp",))
    return (("table_lamp", "wall_lamp"), ("ceiling_lamp",))


def named_in(text: str) -> str | None:
    """The library's category of the first word in a text that has one, such as a file's name."""
    parts = plain(text).split("_")
    spans = [parts[i:j] for i in range(len(parts)) for j in range(len(parts), i, -1)]
    known = library_words()
    return next((known[word] for span in spans if (word := "_".join(span)) in known), None)


def _match_word(word: str) -> tuple[str, str] | None:
    """The known word that says what a word names, and its category; None where none does."""
    known = library_words()
    for form in _forms(plain(word)):
        if form in known:
            return form, known[form]
        if form in OTHERS or form in _BUILDING or form in _NOTHING or form in _LAMPS:
            return form, form
    return None


def _forms(name: str) -> Iterator[str]:
    """A word, its singular, and the nouns at its end: those that say what it is."""
    yield from _numbers(name)
    parts = name.split("_")
    ends = [i for i, part in enumerate(parts) if part in _JOINTS and i > 0]
    parts = parts[: ends[0]] if ends else parts
    for start in range(not ends, len(parts)):
        head = "_".join(parts[start:])
        if start == 0 or head.removesuffix("s") not in _NO_HEADS:
            yield from _numbers(head)


def _numbers(name: str) -> Iterator[str]:
    yield name
    if name.endswith("s"):
        yield name[:-1]
