"""What becomes of each concept of OpenUSD in a picture: the table ``mapping.toml``, looked up."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any, Final, Literal, cast

from pxr import Plug, Sdr, Tf, Usd

Outcome = Literal["supported", "approximated", "reported", "ignored"]

TABLE: Final = Path(__file__).with_name("mapping.toml")

_ROOT: Final = "SchemaBase"
# The nodes of the specification of UsdPreviewSurface.
_PREVIEW: Final = ("UsdPreviewSurface", "UsdUVTexture", "UsdTransform2d", "UsdPrimvarReader_*")


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes:
        name: A schema, ``schema.property`` or ``shader.input``, perhaps with ``*``.
        outcome: Whether a picture has it.
        becomes: What it is there, or why it is not.
        told_by: Who tells of it; empty where its row is all there is to tell.
    """

    name: str
    outcome: Outcome
    becomes: str
    told_by: str = ""

    @property
    def is_told_here(self) -> bool:
        """Whether only the table reports its authored values."""
        return self.outcome == "reported" and not self.told_by


@cache
def _table() -> dict[str, dict[str, Any]]:
    return tomllib.loads(TABLE.read_text(encoding="utf-8"))


@cache
def rows(section: Literal["types", "properties", "shaders"]) -> Mapping[str, Row]:
    """The rows of a section by their names, in the order of the table."""
    found = _table()[section]
    return {name: Row(name, cast(Outcome, row[0]), *row[1:]) for name, row in found.items()}


@cache
def told_of() -> frozenset[str]:
    """The properties whose rows are all there is to tell of them."""
    found = rows("properties").values()
    return frozenset(row.name.partition(".")[2] for row in found if row.is_told_here)


def neutral(name: str) -> tuple[Any, ...]:
    """Values of a property that mean the same as none, beside its fallback."""
    return tuple(_table()["neutral"].get(name, ()))


def row_of_type(schema: str) -> Row | None:
    """The row of a concrete type or an applied API schema; None for what is not OpenUSD's."""
    return _row("types", schema)


def row_of_property(schemas: Iterable[str], name: str) -> Row | None:
    """The row of a property.

    Args:
        schemas: The schemas that a prim is made of, the nearest first (`lineage`).
        name: The property's.
    """
    known = (one for one in schemas if _may_bring(one, name))
    return next(filter(None, (_row("properties", f"{one}.{name}") for one in known)), None)


@cache
def _may_bring(schema: str, name: str) -> bool:
    """Whether a property may come from a schema: of what is applied once, not others'."""
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(schema)
    single = definition and not Usd.SchemaRegistry.IsMultipleApplyAPISchema(schema)
    return not single or name in definition.GetPropertyNames()


def row_of_input(shader: str, name: str) -> Row | None:
    """The row of an input of a shader of OpenUSD's."""
    return _row("shaders", f"{shader}.{name}")


@cache
def _row(section: Literal["types", "properties", "shaders"], name: str) -> Row | None:
    table = rows(section)
    if name in table:
        return table[name]
    # Names have as many words as their patterns: a star stands for no full stop.
    return next(
        (row for key, row in table.items() if "*" in key or "[" in key if fnmatchcase(name, key)),
        None,
    )


@cache
def lineage(kind: str, applied: tuple[str, ...] = ()) -> tuple[str, ...]:
    """The schemas that a prim is made of, the nearest first.

    Args:
        kind: Its type, or an applied API schema; empty for a prim without a type.
        applied: What is applied to it, with the names of instances.
    """
    registry = Usd.SchemaRegistry()
    own = registry.GetTypeFromSchemaTypeName(kind) if kind else Tf.Type()
    ancestors = own.GetAllAncestorTypes() if own else ()
    names = [str(registry.GetSchemaTypeName(one)) for one in ancestors]
    found = registry.FindConcretePrimDefinition(kind) or (
        registry.FindAppliedAPIPrimDefinition(kind)
    )
    built_in = found.GetAppliedAPISchemas() if found else ()
    apis = [one for name in applied for one in (name, *_built_in(name))]
    found_names = [*names, *apis, *built_in]
    return tuple(
        dict.fromkeys(n.partition(":")[0] for n in found_names if n not in ("", _ROOT, "Typed"))
    )


def _built_in(api: str) -> tuple[str, ...]:
    found = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(api.partition(":")[0])
    return tuple(found.GetAppliedAPISchemas()) if found else ()


def schemas() -> dict[str, tuple[str, tuple[str, ...]]]:
    """Every concrete type and applied API schema of OpenUSD: its module, and its properties.

    The properties of those that may be applied several times have ``__INSTANCE_NAME__``.
    """
    registry, plugins = Usd.SchemaRegistry(), Plug.Registry()
    found = {}
    for kind in Tf.Type.FindByName("UsdSchemaBase").GetAllDerivedTypes():
        name = str(registry.GetSchemaTypeName(kind))
        if not (registry.IsConcrete(kind) or registry.IsAppliedAPISchema(kind)):
            continue
        module = str(plugins.GetPluginForType(kind).name)
        # What others have plugged in is not OpenUSD's.
        if module.lower().startswith("usd"):
            definition = registry.FindConcretePrimDefinition(name) or (
                registry.FindAppliedAPIPrimDefinition(name)
            )
            found[name] = module, tuple(map(str, definition.GetPropertyNames()))
    return dict(sorted(found.items()))


def shader_inputs() -> dict[str, tuple[str, ...]]:
    """The inputs of every shader of the specification of UsdPreviewSurface."""
    registry = Sdr.Registry()
    nodes = (
        registry.GetShaderNodeByIdentifier(name)
        for name in sorted(map(str, registry.GetShaderNodeIdentifiers()))
        if any(fnmatchcase(name, pattern) for pattern in _PREVIEW)
    )
    return {str(node.GetIdentifier()): tuple(node.GetShaderInputNames()) for node in nodes}
