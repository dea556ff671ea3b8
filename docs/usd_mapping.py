"""Writes docs/reference/usd-mapping.md from the package's table: ``python -m docs.usd_mapping``."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from openrooms_usd.usd import mapping
from openrooms_usd.usd.mapping import Row

PAGE: Final = Path(__file__).with_name("reference") / "usd-mapping.md"

_INTRODUCTION: Final = """\
# From USD to pictures

What becomes of every concept of OpenUSD {version} when a stage is rendered or converted: \
{types} types and applied API schemas, {properties} properties, {inputs} inputs of shaders. \
[USD stages](usd.md) has more words on what counts most.

| | |
|---|---|
| supported | the picture has it |
| approximated | the picture has something near; the report says so where that can be seen |
| reported | the picture lacks it; the report says so |
| ignored | it means nothing to a picture |

A row counts for all that its name stands for (`*`), and for schemas that inherit from its own, \
unless they have a row themselves. This page is written by `python -m docs.usd_mapping` from \
`openrooms_usd/usd/mapping.toml`.
"""


def page() -> str:
    """The page's text."""
    schemas, shaders = mapping.schemas(), mapping.shader_inputs()
    found: dict[str, dict[str, Row]] = {}
    # A row belongs where it is first met.
    for name, (module, properties) in schemas.items():
        inherited = mapping.lineage(name)
        rows = (
            mapping.row_of_type(name),
            *(mapping.row_of_property(inherited, one) for one in properties),
        )
        found.setdefault(_titled(module), {}).update(_named(rows))
    every = [*mapping.rows("types"), *mapping.rows("properties")]
    taken: set[str] = set()
    parts = [
        _INTRODUCTION.format(
            version=".".join(map(str, _version())),
            types=len(schemas),
            properties=len({(n, p) for n, (_, all_) in schemas.items() for p in all_}),
            inputs=sum(map(len, shaders.values())),
        )
    ]
    for title, rows in sorted(found.items(), key=lambda item: (item[0] not in _FIRST, item[0])):
        own = [rows[name] for name in every if name in rows and name not in taken]
        taken |= {row.name for row in own}
        parts.append("\n".join([f"## {title}\n", *_lines(own)]) + "\n")
    nodes = mapping.rows("shaders").values()
    parts.append("\n".join(["## Shaders of UsdPreviewSurface\n", *_lines(nodes)]) + "\n")
    return "\n".join(parts)


# The properties of all that has a place are UsdGeom's.
_FIRST: Final = ("UsdGeom",)


def _version() -> tuple[int, ...]:
    from pxr import Usd

    return tuple(Usd.GetVersion())


def _titled(module: str) -> str:
    return module[0].upper() + module[1:]


def _named(rows: Iterable[Row | None]) -> dict[str, Row]:
    return {row.name: row for row in rows if row is not None}


def _lines(rows: Iterable[Row]) -> Iterator[str]:
    yield "| USD | in a picture | |"
    yield "|---|---|---|"
    for row in rows:
        yield f"| `{row.name}` | {row.becomes} | {row.outcome} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
