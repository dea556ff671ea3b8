"""Where a user keeps what was made before: textures, skies, shapes and light, a folder each."""

import os
from pathlib import Path
from typing import Final

# Says where the cache is; empty or one of these words: there is none.
VARIABLE: Final = "ORUSD_CACHE"
_OFF: Final = ("", "0", "off", "no", "none")


def cache_folder(kind: str) -> Path | None:
    """Where things of a kind are kept, such as ``textures``.

    Below ``$ORUSD_CACHE``, else below ``$XDG_CACHE_HOME`` or ``~/.cache``. None where it is
    switched off, or where there is no home.
    """
    given = os.environ.get(VARIABLE)
    if given is not None:
        return None if given.lower() in _OFF else Path(given) / kind
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        home = Path(base) if base else Path.home() / ".cache"
    except RuntimeError:
        return None
    return home / "openrooms_usd" / kind
