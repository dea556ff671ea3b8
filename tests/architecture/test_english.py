"""Plain English, as far as it can be counted: turns of phrase, and sentences that are too long.

``python -m tests.architecture.test_english [PART]`` prints the numbers of the table and the places.
"""

import ast
import inspect
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
LONGEST = 40  # words of a sentence

# Say "must be", "is not a", "is reported", "users", "is omitted" instead.
PHRASES = re.compile(
    r"(?<!there )\b(?:is|are|was|were) no\b(?! longer\b| more than\b| less than\b)(?!-)"
    r"|(?<!there )\b(?:is|are|was|were) (?-i:none)\b"
    r"|\b(?:is|are|was|were) told\b(?! apart)|\btold of\b"
    r"|\b(?:nobody|somebody|anybody|whoever)\b"
    r"|\b(?:of|by|for|to|as|than) who\b"
    r"|\bhangs? not\b|\bone's own\b|\bas is said\b"
    r"|\b(?:left|leave|leaves|leaving)(?: \w+)? away\b",
    re.IGNORECASE,
)


class Limits(NamedTuple):
    """The most of each that a part may have."""

    phrases: int
    sentences: int


LIMITS: dict[str, Limits] = {
    "converters/orusd_gltf": Limits(0, 0),
    "converters/orusd_hypersim": Limits(0, 0),
    "converters/orusd_mitsuba": Limits(0, 0),
    "converters/orusd_nerf": Limits(0, 0),
    "converters/orusd_openrooms": Limits(0, 0),
    "converters/orusd_preview": Limits(0, 0),
    "converters/orusd_scans": Limits(0, 0),
    "converters/orusd_urdf": Limits(0, 0),
    "converters/orusd_usdz": Limits(0, 0),
    "converters/orusd_webdataset": Limits(0, 0),
    "docs": Limits(0, 0),
    "openrooms_usd": Limits(0, 0),
    "openrooms_usd/api": Limits(0, 0),
    "openrooms_usd/appearance": Limits(0, 0),
    "openrooms_usd/building": Limits(0, 0),
    "openrooms_usd/cli": Limits(0, 0),
    "openrooms_usd/comparison": Limits(0, 0),
    "openrooms_usd/dataset": Limits(0, 0),
    "openrooms_usd/demo": Limits(0, 0),
    "openrooms_usd/description": Limits(0, 0),
    "openrooms_usd/edits": Limits(0, 0),
    "openrooms_usd/furniture": Limits(0, 0),
    "openrooms_usd/generation": Limits(0, 0),
    "openrooms_usd/geometry": Limits(0, 0),
    "openrooms_usd/importing": Limits(0, 0),
    "openrooms_usd/library": Limits(0, 0),
    "openrooms_usd/loading": Limits(0, 0),
    "openrooms_usd/physics": Limits(0, 0),
    "openrooms_usd/rendering": Limits(0, 0),
    "openrooms_usd/scan": Limits(0, 0),
    "openrooms_usd/showroom": Limits(0, 0),
    "openrooms_usd/simulation": Limits(0, 0),
    "openrooms_usd/steps": Limits(0, 0),
    "openrooms_usd/unpickling": Limits(0, 0),
    "openrooms_usd/usd": Limits(0, 0),
    "openrooms_usd/validation": Limits(0, 0),
    "openrooms_usd/view": Limits(0, 0),
    "schemas": Limits(0, 0),
    "top": Limits(0, 0),
}


class Hit(NamedTuple):
    """A turn of phrase, or a sentence that is too long, and where it is."""

    place: str
    text: str


def passages_of_python(source: str) -> Iterator[tuple[int, str]]:
    """Line and text of each docstring, message and block of comments."""
    tree = ast.parse(source)
    formatted = [node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr)]
    pieces = {id(part) for node in formatted for part in ast.walk(node) if part is not node}
    for node in ast.walk(tree):
        if id(node) in pieces:
            continue
        if isinstance(node, ast.JoinedStr):
            yield (
                node.lineno,
                "".join(
                    str(part.value) if isinstance(part, ast.Constant) else "{}"
                    for part in node.values
                ),
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, inspect.cleandoc(node.value)
    block, first, last = "", 0, 0
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            whole, line = token.line.lstrip().startswith("#"), token.start[0]
            if not (whole and line == last + 1):
                yield first, block
                block, first = "", line
            block += f"\n{token.string[1:]}"
            last = line if whole else 0
    yield first, block


def passages_of_markdown(text: str) -> Iterator[tuple[int, str]]:
    """Line and text of each paragraph, item of a list and cell of a table; no code."""
    code = re.compile(r"^( *)```.*?^\1```$", re.MULTILINE | re.DOTALL)
    text = code.sub(lambda match: "\n" * match[0].count("\n"), text)
    for match in re.finditer(r"(?:^(?! *$).+\n?)+", text, re.MULTILINE):
        line = text.count("\n", 0, match.start()) + 1
        for piece in re.split(r"\n *(?=[-*] |\d+\. |\|)|\|", match[0]):
            yield line, piece


def parts_of_python(text: str) -> Iterator[str]:
    """Paragraphs, and entries of ``Args:`` and the like; no tables, lists of names or formulas."""
    for part in re.split(r"\n\s*\n|\n(?= *(?:[\w*]+(?:, [\w*]+)*:|[-*] ))", text):
        names = len(part.split()) > LONGEST and not re.search(r"[.,:;]", part)
        formula = len(re.findall(r"[=+^<>{}()]", part)) > len(part.split()) / 4
        if not names and not formula and not re.search(r"\S   +\S", part):
            yield part


def sentences(text: str) -> Iterator[str]:
    yield from (" ".join(s.split()) for s in re.split(r"(?<=[.!?])[)\"']*\s", text))


def hits(path: Path) -> tuple[list[Hit], list[Hit]]:
    """Phrases and long sentences of a file."""
    source = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        passages = [
            (line, part)
            for line, text in passages_of_python(source)
            for part in parts_of_python(text)
        ]
    elif path.suffix == ".md":
        passages = list(passages_of_markdown(source))
    else:
        passages = list(enumerate(source.splitlines(), 1))
    phrases, long = [], []
    for line, passage in passages:
        place = f"{path.relative_to(ROOT)}:{line}"
        for sentence in sentences(passage):
            phrases += [Hit(place, sentence) for _ in PHRASES.finditer(sentence)]
            if path.suffix in {".py", ".md"} and len(sentence.split()) > LONGEST:
                long.append(Hit(place, sentence))
    return phrases, long


def parts() -> dict[str, list[Path]]:
    """Files by the part of the project that they belong to."""
    found: dict[str, list[Path]] = {"top": sorted(ROOT.glob("*.md"))}
    found["docs"] = sorted((ROOT / "docs").rglob("*.md"))
    for source in ("openrooms_usd", "converters", "schemas"):
        for path in sorted((ROOT / source).rglob("*")):
            if path.suffix in {".py", ".js", ".html", ".toml"}:
                below = path.relative_to(ROOT).parts
                part = source if len(below) == 2 or source == "schemas" else "/".join(below[:2])
                found.setdefault(part, []).append(path)
    return found


def counted(part: str) -> tuple[list[Hit], list[Hit]]:
    found = [hits(path) for path in parts()[part]]
    return [hit for phrases, _ in found for hit in phrases], [h for _, long in found for h in long]


@pytest.mark.parametrize("part", LIMITS)
def test_the_language_stays_plain(part: str) -> None:
    for name, limit, found in zip(Limits._fields, LIMITS[part], counted(part), strict=True):
        listed = "\n".join(f"{hit.place}: {hit.text}" for hit in found)
        assert len(found) <= limit, f"{len(found)} {name}, at most {limit} are allowed:\n{listed}"
        assert len(found) >= limit * 3 // 4 - 5, f"{len(found)} {name}: lower the limit of {limit}"


def test_every_part_has_its_limits() -> None:
    assert set(LIMITS) == set(parts())


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(parts()):
        of_phrases, too_long = counted(name)
        print(f'    "{name}": Limits({len(of_phrases)}, {len(too_long)}),')
        for hit in (*of_phrases, *too_long) if sys.argv[1:] else ():
            print(f"{hit.place}: {hit.text}")
