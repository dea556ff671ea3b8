"""Tables of plain data, as TOML beside the modules that read them."""

import tomllib
from pathlib import Path
from typing import Any


def read_table(module: str, name: str) -> dict[str, Any]:
    """A table beside a module; lists in it are tuples.

    Args:
        module: The module's ``__file__``.
        name: The file's name, written out, so that it counts as the module's code.
    """
    text = Path(module).with_name(name).read_text(encoding="utf-8")
    return {key: _fixed(value) for key, value in tomllib.loads(text).items()}


def _fixed(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _fixed(inner) for key, inner in value.items()}
    return tuple(map(_fixed, value)) if isinstance(value, list) else value
