"""Names that XML, file systems and engines all take: plain characters, each one unique."""

import hashlib
import re
import unicodedata
from typing import Final

from openrooms_usd.portable import RESERVED

_FOREIGN: Final = re.compile(r"[^A-Za-z0-9_]+")
_PLAIN: Final = re.compile(r"[A-Za-z0-9_]+")
# What never moves has this name in MuJoCo, and a link of it is held in Gazebo and Drake; names
# between two underscores are SDFormat's own.
_RESERVED: Final = re.compile(r"world|__.*__")


def plain(text: str) -> str:
    """The same word in ASCII letters, digits and underscores; accents are dropped.

    ``Fauteuil à côté`` becomes ``Fauteuil_a_cote``; what has no such letter becomes ``object``.
    """
    decomposed = unicodedata.normalize("NFKD", text)
    letters = "".join(c for c in decomposed if not unicodedata.combining(c))
    return _FOREIGN.sub("_", letters).strip("_") or "object"


def safe(text: str) -> str:
    """A plain name that is another one for every text: what had to be changed ends with a hash.

    So do words that a format keeps for itself, such as ``world``.

    Names do not depend on other names, so that readers of the files find a thing by its name.
    """
    if _PLAIN.fullmatch(text) and not _RESERVED.fullmatch(text):
        return text
    return f"{plain(text)}_{hashlib.sha256(text.encode()).hexdigest()[:8]}"


class Names:
    """Gives every file a name of its own; the same things in the same order get the same ones."""

    def __init__(self) -> None:
        self._taken = set(RESERVED)

    def unique(self, text: str) -> str:
        """A plain name that was not given before, whatever the case of its letters."""
        base = plain(text)
        name, number = base, 1
        # Some file systems take capitals for small letters.
        while name.lower() in self._taken:
            number += 1
            name = f"{base}_{number}"
        self._taken.add(name.lower())
        return name
