"""Labels of prims: our categories, our classes in the lists of others, and what others label.

Which classes a category has stands in its record. NYU40: as ScanNet's table of labels
(scannetv2-labels.combined.tsv) files the same word, so that numbers agree with its label images;
our side tables are its end tables, our rugs its rugs. OpenRooms: its class of the same name, or of
what it rendered such models as; else unlabeled. ADE20K and COCO: the class that the thing is by the
class's own words, and else unlabeled; what is several of COCO's at once, as cutlery is, is so too.
A class is known by its number; 0 is ``unlabeled`` in all.

What a thing is others say by ``SemanticsLabelsAPI`` with another name than ours, or by the
``SemanticsAPI`` of Isaac Sim before 5.0, and in the words of their captures.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Final

from pxr import Usd, UsdSemantics, Vt

from openrooms_usd import names
from openrooms_usd.furniture.record import UNLABELED, Classes
from openrooms_usd.furniture.registry import record, records
from openrooms_usd.furniture.words import BROAD, plain, spelled
from openrooms_usd.tables import read_table
from openrooms_usd.usd.places.frames import TIME

_TABLES: Final = read_table(__file__, "semantics.toml")
OPENROOMS45: Final[tuple[str, ...]] = _TABLES["openrooms45"]
NYU40: Final[tuple[str, ...]] = _TABLES["nyu40"]
ADE20K: Final[tuple[str, ...]] = _TABLES["ade20k"]
COCO_GROUPS: Final[dict[str, dict[str, int]]] = _TABLES["coco"]
"""Numbers of COCO's classes by their supercategories."""
COCO: Final = {0: UNLABELED} | dict(
    sorted((number, name) for group in COCO_GROUPS.values() for name, number in group.items())
)

TAXONOMIES: Final[dict[str, dict[int, str]]] = {
    names.OPENROOMS45: dict(enumerate(OPENROOMS45)),
    names.NYU40: dict(enumerate(NYU40)),
    names.ADE20K: dict(enumerate(ADE20K)),
    names.COCO: COCO,
}
"""The names of closed class lists by their numbers, by the name of their taxonomy."""

WORDS: Final = (names.CATEGORY, "class")
"""Taxonomies whose labels are words for what a thing is: ours, and that of Isaac Sim."""

LABEL: Final = "its label"
"""How each sentence of `unread_labels` begins."""

_SAYING: Final = frozenset((*WORDS, *TAXONOMIES))
_UNNUMBERED: Final = frozenset((names.PART, names.CAPTURED))
_LABELS: Final = "semantics:labels:"
# Isaac Sim before 5.0: an API that USD does not know, and what it wrote.
_OLD_API: Final = "SemanticsAPI"
_OLD: Final = "semantic:{}:params:semantic{}"

_NUMBERS: Final = {
    taxonomy: {name: number for number, name in listed.items()}
    for taxonomy, listed in TAXONOMIES.items()
}


@cache
def classes() -> dict[str, Classes]:
    """What each of our categories is in those lists, by name."""
    return {name: told.classes for name, told in sorted(records())}


def class_of(category: str, taxonomy: str) -> str:
    """The class of one of our categories in a taxonomy.

    An unknown word keeps its name if the taxonomy has it too.

    Args:
        category: Such as ``armchair``; any word will do.
        taxonomy: A key of `TAXONOMIES`.

    Returns:
        A member of the taxonomy's list; ``unlabeled`` where it has no class for it.
    """
    known = record(category)
    name: str = category if known is None else getattr(known.classes, taxonomy)
    return name if name in _NUMBERS[taxonomy] else UNLABELED


def number_of(name: str, taxonomy: str) -> int:
    """The number of a class; 0 where the taxonomy has none of that name."""
    return _NUMBERS[taxonomy].get(name, 0)


def label(prim: Usd.Prim, category: str) -> None:
    """Label a prim with its category and its class in every taxonomy."""
    _author(prim, names.CATEGORY, category)
    for taxonomy in TAXONOMIES:
        _author(prim, taxonomy, class_of(category, taxonomy))


def label_part(prim: Usd.Prim, part: str) -> None:
    """Label a mesh of an object with the semantic part that it is."""
    _author(prim, names.PART, part)


def _author(prim: Usd.Prim, taxonomy: str, value: str) -> None:
    UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr([value])


def read_label(prim: Usd.Prim, taxonomy: str) -> str | None:
    """The nearest label of a taxonomy on a prim or above it; None where there is none."""
    while prim and not prim.IsPseudoRoot():
        labels = UsdSemantics.LabelsAPI(prim, taxonomy)
        values = labels.GetLabelsAttr().Get() if labels else None
        # A layer of others may have written anything under this name.
        if isinstance(values, Vt.TokenArray) and len(values):
            return str(values[0])
        prim = prim.GetParent()
    return None


# What others label.

Said = Mapping[str, tuple[str, ...]]


def is_labelled(prim: Usd.Prim) -> bool:
    """Whether a prim itself says what it is, in words or by a class."""
    return not _SAYING.isdisjoint(own_labels(prim))


def own_labels(prim: Usd.Prim) -> Said:
    """The labels that stand on a prim itself, by their taxonomies."""
    found: dict[str, tuple[str, ...]] = {}
    # The second also names what USD does not know.
    written = prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    for api in dict.fromkeys((*prim.GetAppliedSchemas(), *written)):
        kind, _, name = api.partition(":")
        if kind == "SemanticsLabelsAPI":
            taxonomy, words = name, prim.GetAttribute(f"{_LABELS}{name}").Get(TIME)
        elif kind == _OLD_API:
            said = (prim.GetAttribute(_OLD.format(name, end)) for end in ("Type", "Data"))
            taxonomy, words = (str(one.Get(TIME) or "") if one else "" for one in said)
            words = Vt.StringArray([words] if words else [])
        else:
            continue
        # A layer of others may have written anything under this name.
        if isinstance(words, Vt.TokenArray | Vt.StringArray) and len(words):
            found[taxonomy] = (*found.get(taxonomy, ()), *map(str, words))
    return found


def read_category(prims: Iterable[Usd.Prim]) -> str | None:
    """What the first prim that says it is, as the library spells it where it has a word for it.

    Args:
        prims: A prim, and what stands above it, the nearest first.
    """
    return next(filter(None, (_category(own_labels(prim)) for prim in prims)), None)


def _category(said: Said) -> str | None:
    words = _words(said)
    return _most_specific_word(words) or next(reversed(words), None)


def _words(said: Said) -> tuple[str, ...]:
    return tuple(word for taxonomy in WORDS for word in said.get(taxonomy, ()))


def _most_specific_word(words: Sequence[str]) -> str | None:
    """The most specific known word for a thing; hierarchies end with it."""
    known = [name for word in words if (name := _spelled(word))]
    special = [name for name in known if name not in BROAD]
    return next(reversed(special or known), None)


@cache
def _spelled(word: str) -> str | None:
    """A word as a category or class has it; None where none has."""
    names_of_it = (word, spelled(word) or "", plain(word))
    known = (name for test in (record, _is_class) for name in names_of_it if test(name))
    return next(known, None)


def _is_class(name: str) -> bool:
    return any(name in numbers for numbers in _NUMBERS.values())


def read_number(prims: Iterable[Usd.Prim], taxonomy: str) -> int:
    """The number of a class, as the first prim is labelled that says one, or else a category.

    Args:
        prims: A prim, and what stands above it, the nearest first.
        taxonomy: A key of `TAXONOMIES`.

    Returns:
        The number; 0 for what has no class in the taxonomy.
    """
    for prim in prims:
        said = own_labels(prim)
        if taxonomy in said:
            return max(number_of(_listed(word, taxonomy), taxonomy) for word in said[taxonomy])
        if category := _category(said):
            return number_of(class_of(category, taxonomy), taxonomy)
    return 0


def _listed(word: str, taxonomy: str) -> str:
    return word if word in _NUMBERS[taxonomy] else plain(word)


def unread_labels(prim: Usd.Prim) -> Iterator[str]:
    """The unknown labels of a prim, one sentence each."""
    said = own_labels(prim)
    for taxonomy, words in said.items():
        listed = ", ".join(words)
        if taxonomy in TAXONOMIES:
            if not any(_listed(word, taxonomy) in _NUMBERS[taxonomy] for word in words):
                yield f"{LABEL} {listed} is not a class of {taxonomy}"
        elif taxonomy not in (*WORDS, *_UNNUMBERED):
            known = ", ".join((*WORDS, *TAXONOMIES))
            whose = taxonomy or "a list without a name"
            yield f"{LABEL} {listed} is left out: {whose} is not one of {known}"
    if (
        (words := _words(said))
        and not _most_specific_word(words)
        and TAXONOMIES.keys().isdisjoint(said)
    ):
        yield f"{LABEL} {', '.join(words)} is not a known word: it has no class"
    applied = prim.GetAppliedSchemas()
    for attribute in prim.GetAuthoredPropertiesInNamespace(_LABELS.rstrip(":")):
        name = attribute.GetName()
        if f"SemanticsLabelsAPI:{name.removeprefix(_LABELS)}" not in applied:
            yield f"{LABEL} {name} is left out: its SemanticsLabelsAPI is not applied"
