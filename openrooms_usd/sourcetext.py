"""What the source of a module says: its code without comments and docstrings, and what it imports.

Parsing takes ten times as long as reading. So what a text says is kept in the user's cache, by the
text's own digest.
"""

import ast
import hashlib
import json
import re
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from openrooms_usd import atomic
from openrooms_usd.errors import OutputError
from openrooms_usd.usercache import cache_folder

_FILE_NAME: Final = re.compile(r"[\w-]+\.[a-z]\w{1,4}")
# Texts that a file of the cache holds at most; the package has about a thousand.
_MOST_TEXTS: Final = 5000


@dataclass(frozen=True)
class Text:
    """What the source of a module says, wherever it lies.

    Attributes:
        digest: Of its syntax tree, without docstrings.
        imports: The modules that it imports, with leading dots as written, each with the names
            that it takes from it; none where the module itself is imported.
        files: Strings that may name files beside it.
    """

    digest: str
    imports: tuple[tuple[str, tuple[str, ...]], ...]
    files: tuple[str, ...]


class Texts:
    """What texts say, by their digests: of this process, and of those before it."""

    def __init__(self) -> None:
        # What is read of a tree is determined by this module and by the parser.
        own = hashlib.sha256(Path(__file__).read_bytes() if Path(__file__).is_file() else b"")
        python = f"{sys.version_info[0]}{sys.version_info[1]}"
        folder = cache_folder("code")
        self._file = folder and folder / f"{own.hexdigest()[:16]}-{python}.json"
        self._known: dict[str, Text] = {}
        self._used: set[str] = set()
        self._is_new = False
        with suppress(OSError, ValueError, TypeError, AttributeError):
            read = json.loads(self._file.read_bytes()) if self._file else {}
            self._known = {key: _text_from(value) for key, value in read.items()}

    def of(self, source: bytes) -> Text:
        """What a source says."""
        key = hashlib.sha256(source).hexdigest()
        self._used.add(key)
        if key not in self._known:
            self._known[key] = _parse(source)
            self._is_new = True
        return self._known[key]

    def save(self) -> None:
        """Keep what is new for processes to come; without a cache nothing is kept."""
        if not self._is_new or self._file is None:
            return
        self._is_new = False
        many = len(self._known) > _MOST_TEXTS
        kept = {key: text for key, text in self._known.items() if not many or key in self._used}
        data = {key: [text.digest, text.imports, text.files] for key, text in kept.items()}
        with suppress(OSError, OutputError):
            self._file.parent.mkdir(parents=True, exist_ok=True)
            atomic.write_text(self._file, json.dumps(data))


def _text_from(value: Any) -> Text:
    """A text as it was kept."""
    digest, imports, files = value
    found = tuple((str(start), tuple(map(str, names))) for start, names in imports)
    return Text(str(digest), found, tuple(map(str, files)))


def _parse(source: bytes) -> Text:
    """Parse a text; a text that is not Python counts byte by byte."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return Text(hashlib.sha256(source).hexdigest(), (), ())
    reading = _Reading()
    tree_text = reading.text(tree)
    # What looks for data says where it lies itself.
    files = sorted(set(reading.files)) if "__file__" in reading.names else ()
    digest = hashlib.sha256(tree_text.encode("utf-8", "surrogatepass")).hexdigest()
    return Text(digest, tuple(dict.fromkeys(reading.imports)), tuple(files))


class _Reading:
    """One pass over a syntax tree."""

    def __init__(self) -> None:
        self.imports: list[tuple[str, tuple[str, ...]]] = []
        self.files: list[str] = []
        self.names: set[str] = set()
        self._typing = 0

    def text(self, node: Any) -> str:
        """A node as text, without docstrings; the same for every version of Python."""
        if isinstance(node, list):
            return f"[{','.join([self.text(each) for each in node if not _is_docstring(each)])}]"
        if not isinstance(node, ast.AST):
            return repr(node)
        self._note(node)
        is_typing = isinstance(node, ast.If) and _is_typing(node.test)
        parts = []
        for name in node._fields:
            value = getattr(node, name, None)
            # Fields that newer versions add are empty where nothing new is used.
            if value is None or value == []:
                continue
            self._typing += is_typing and name == "body"
            parts.append(f"{name}={self.text(value)}")
            self._typing -= is_typing and name == "body"
        return f"{type(node).__name__}({','.join(parts)})"

    def _note(self, node: ast.AST) -> None:
        if isinstance(node, ast.Name):
            self.names.add(node.id)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            if _FILE_NAME.fullmatch(node.value):
                self.files.append(node.value)
        elif self._typing:
            return
        elif isinstance(node, ast.Import):
            self.imports += [(alias.name, ()) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            start = "." * node.level + (node.module or "")
            self.imports.append((start, tuple(alias.name for alias in node.names)))


def _is_docstring(node: Any) -> bool:
    """Whether this is a text that stands by itself, such as a docstring."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _is_typing(test: ast.expr) -> bool:
    return isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"
