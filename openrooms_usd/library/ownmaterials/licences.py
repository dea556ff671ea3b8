"""Under which terms a folder's content may be used, read from the text that lies in it."""

import re
from pathlib import Path
from typing import Final

from openrooms_usd import untrusted
from openrooms_usd.library.ownmaterials.material import UNKNOWN_LICENCE

_FILES: Final = re.compile(r"(licen[cs]e|copying|copyright)([._-].*)?", re.IGNORECASE)
_MOST_BYTES: Final = 65_536
_MOST_LETTERS: Final = 120
_SPDX: Final = re.compile(r"SPDX-License-Identifier:\s*(\S[^\r\n]*)")
# What the usual texts say near their beginning, as SPDX names them; the stricter ones first.
_KNOWN: Final = (
    (r"CC0|creative commons zero|public domain dedication", "CC0-1.0"),
    (r"CC[ -]BY-NC-SA|attribution-noncommercial-sharealike", "CC-BY-NC-SA"),
    (r"CC[ -]BY-NC-ND|attribution-noncommercial-noderiv", "CC-BY-NC-ND"),
    (r"CC[ -]BY-NC|attribution-noncommercial", "CC-BY-NC"),
    (r"CC[ -]BY-SA|attribution-sharealike", "CC-BY-SA"),
    (r"CC[ -]BY|creative commons attribution", "CC-BY"),
    (r"apache license,?\s+version 2\.0|apache-2\.0", "Apache-2.0"),
    (r"\bMIT license\b", "MIT"),
)
_VERSIONED: Final = re.compile(r"CC-BY.*")
_VERSION: Final = re.compile(r"\b([234]\.0)\b")


def licence_files(folder: Path) -> list[Path]:
    """The files of a folder that state a licence; sorted."""
    return sorted(p for p in folder.iterdir() if p.is_file() and _FILES.fullmatch(p.name))


def licence_in(folder: Path) -> str:
    """The licence that a folder states: an SPDX name, the first line of its text, or unknown.

    Raises:
        InputError: The file that states it cannot be read.
    """
    for file in licence_files(folder):
        with untrusted.opened(file, "text", remedy="check its permissions") as content:
            text = untrusted.decoded(content.read(_MOST_BYTES))
        if licence := _name(text):
            return licence
    return UNKNOWN_LICENCE


def _name(text: str) -> str:
    stated = _SPDX.search(text)
    if stated:
        return stated[1].strip()[:_MOST_LETTERS]
    for pattern, name in _KNOWN:
        if re.search(pattern, text[:2000], re.IGNORECASE):
            version = _VERSION.search(text[:2000]) if _VERSIONED.fullmatch(name) else None
            return f"{name}-{version[1]}" if version else name
    lines = (re.sub(r"[\x00-\x1f\x7f]", " ", line).strip() for line in text.splitlines())
    return next((line for line in lines if line), "")[:_MOST_LETTERS]
