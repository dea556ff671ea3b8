"""What USD may open: files of others are looked through before USD's own parser sees them.

USD reads text by recursion and takes any bytes for text. A file that nests deeply enough ends the
process, and one byte that is not UTF-8 ends in an exception wherever Python asks for a name. So
every file that a stage is made of is looked through first: whether it is a regular file of a
sensible size, whether its text is text, and how deeply it nests.
"""

import re
from collections.abc import Iterator
from functools import cache
from io import SEEK_END, BytesIO
from itertools import chain
from pathlib import Path, PurePosixPath
from typing import Final

from pxr import Ar, Sdf, UsdUtils

from openrooms_usd import ledger, untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.names import SCENE
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.usd.files.crate_reader import check_crate, check_crate_reads
from openrooms_usd.usd.files.diagnostics import UNREADABLE, reading

Facts = tuple[int, ...]
# What layers name, by the layer, the state of its file and the variables of its expressions.
_KNOWN: Final[dict[tuple[str, Facts, str], tuple[str, ...]]] = {}

# Rooms nest some ten deep; USD's parser overflows its stack beyond some thousands.
MAX_DEPTH: Final = 200

_PACKAGE: Final = ".usdz"
_DESCRIPTIONS: Final = (".yaml", ".yml")
_TEXT: Final = b"#"
_REMEDY: Final = "open it with a USD tool to see the mistake, or export it again"
# What may hold brackets that nest nothing: strings, names of files, comments. One that is not
# closed goes on to the end, as it does for USD. Groups are not possessive: those of Python before
# 3.11.5 take less than there is.
_LITERAL: Final = re.compile(
    rb'"""[^"\\]*+(?:(?:\\.|"(?!""))[^"\\]*+)*(?:"""|\Z)'
    rb"|'''[^'\\]*+(?:(?:\\.|'(?!''))[^'\\]*+)*(?:'''|\Z)"
    rb'|"[^"\\\n]*+(?:\\.[^"\\\n]*+)*"'
    rb"|'[^'\\\n]*+(?:\\.[^'\\\n]*+)*'"
    rb"|@@@.*?(?:@@@|\Z)|@[^@\n]*+@|\#[^\n]*+|//[^\n]*+|/\*.*?(?:\*/|\Z)",
    re.DOTALL,
)
# Expressions are parsed by recursion too, wherever they stand.
_EXPRESSIONS: Final = re.compile(rb"`[^`]{%d,}+" % MAX_DEPTH)
_OPENING: Final = b"([{"
_OTHER: Final = bytes(set(range(256)) - set(b"()[]{}"))
_ALIKE: Final = bytes.maketrans(b"[]{}", b"()()")


def check_text(data: bytes, place: object) -> None:
    """See that USDA text can be given to USD: it is UTF-8, and does not nest too deeply.

    Args:
        data: The text.
        place: Where it is from, for messages.

    Raises:
        InputError: It is not.
    """
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"not a readable USD file: byte 0x{data[error.start]:02x} is not UTF-8 text",
            place=f"{place}:{line}",
            remedy=_REMEDY,
        ) from None
    inner = _EXPRESSIONS.findall(data)
    if _nests_deeply(_LITERAL.sub(b" ", data)) or any(map(_nests_deeply, inner)):
        raise _too_deep(place)


def _nests_deeply(text: bytes) -> bool:
    """Whether brackets nest deeper than is sensible; those that close nothing count for nothing."""
    if sum(text.count(sign) for sign in _OPENING) <= MAX_DEPTH:
        return False
    brackets = text.translate(_ALIKE, _OTHER)
    # Each pass takes the innermost pairs away.
    for _ in range(MAX_DEPTH):
        shorter = brackets.replace(b"()", b"")
        if len(shorter) == len(brackets):
            break
        brackets = shorter
    return b"()" in brackets or brackets.count(b"(") > MAX_DEPTH


def check_file(path: Path) -> None:
    """Look through one file, without what it refers to; USD opens nothing.

    Raises:
        InputError: USD should not see it: see `check_stage_file`.
    """
    if path.suffix.lower() == _PACKAGE:
        untrusted.checked(path, "archive")
        return
    with untrusted.opened(path, "usd") as stream:
        # Crates are read in pieces, as they can be large; USD itself rejects files that are not
        # USD.
        if not stream.read(len(_TEXT)).startswith(_TEXT):
            size = stream.seek(0, SEEK_END)
            check_crate(stream, size, path)
            if not ledger.wrote(path):
                check_crate_reads(str(path), size)
            return
    check_text(untrusted.read_bytes(path, "usd"), path)


def check_stage_file(path: Path, *, is_whole: bool = False) -> tuple[Sdf.Layer, ...]:
    """Look through a USD file and all layers that it is composed of, before it is composed.

    What was looked through and has not changed since is not read again.

    Args:
        path: Any USD file.
        is_whole: Whether its sublayers, and theirs, must be readable where they are there. USD
            passes over those that are not, and what they say would be gone.

    Returns:
        The layers. As long as they are referenced, USD reads none of them again.

    Raises:
        InputError: One of the files is not a regular file, is too large, is not text, or nests too
            deeply. What is missing or damaged in another way is left to USD to tell.
    """
    _check_meant(path)
    untrusted.checked(path, "archive" if path.suffix.lower() == _PACKAGE else "usd")
    root = str(path.absolute())
    waiting, seen, layers = [root], {root}, []
    variables: dict[str, object] | None = None
    stack = {root} if is_whole else set()
    while waiting:
        name = waiting.pop()
        facts = _facts(name)
        layer = None if facts is None else _opened(name, facts)
        if layer is None or facts is None:
            if name in stack:
                with reading(name):
                    Sdf.Layer.FindOrOpen(name)
            continue
        layers.append(layer)
        if name in stack:
            stack.update(_sublayers(layer))
        if variables is None:
            with reading(name):
                variables = dict(layer.expressionVariables)
        for other in _references(layer, facts, variables):
            if other not in seen:
                seen.add(other)
                waiting.append(other)
    return tuple(layers)


def _check_meant(path: Path) -> None:
    """Refuse a description and a composed folder in the place of the stage that is made of it."""
    scene = path / SCENE
    if path.suffix.lower() in _DESCRIPTIONS and path.is_file():
        raise InputError(
            "this is the description of a room, not a stage",
            place=path,
            remedy=f"compose it first: orusd compose {path} -o OUT; then name OUT/{SCENE}",
        )
    if path.is_dir() and scene.is_file():
        raise InputError("this is a folder, not a file", place=path, remedy=f"name {scene}")


def _sublayers(layer: Sdf.Layer) -> Iterator[str]:
    with reading(layer.identifier):
        for path in layer.subLayerPaths:
            if path and "\0" not in path:
                whole = Sdf.ComputeAssetPathRelativeToLayer(layer, path)
                yield str(Ar.GetResolver().Resolve(whole))


def _facts(name: str) -> Facts | None:
    """What tells one state of a layer's file from others; None where there is no file."""
    try:
        stamp = Path(Ar.SplitPackageRelativePathOuter(name)[0]).stat()
    except (OSError, ValueError):
        return None
    return stamp.st_mtime_ns, stamp.st_ctime_ns, stamp.st_size, stamp.st_ino


def _opened(name: str, facts: Facts) -> Sdf.Layer | None:
    """A layer that was looked through, as its file is; None where USD cannot open it."""
    _check_bytes(name, facts)
    try:
        layer = Sdf.Layer.Find(name)
        if layer:
            # USD caches layers by name; one that was written again since then is read again.
            layer.Reload()
        else:
            layer = Sdf.Layer.FindOrOpen(name)
    except UNREADABLE:
        return None
    if layer is not None:
        _check_depth(name, facts)
    return layer


@cache
def _check_bytes(name: str, facts: Facts) -> None:
    """Look through the bytes that USD will read."""
    if not Ar.IsPackageRelativePath(name):
        check_file(Path(name))
        if not name.lower().endswith(_PACKAGE):
            return
    if name.lower().rstrip("]").endswith(_PACKAGE):
        # USD opens the first layer of a package, and finds it where it starts itself.
        for entry in _entries(name):
            _check_bytes(Ar.JoinPackageRelativePath([name, entry]), facts)
        return
    data = _packaged(name)
    if data.startswith(_TEXT):
        check_text(data, name)
    else:
        check_crate(BytesIO(data), len(data), name)
        check_crate_reads(name, len(data))


def _entries(package: str) -> list[str]:
    """The layers and packages in a package, by USD's own reader."""
    if not Ar.IsPackageRelativePath(package):
        return _listed(package)
    with scratch_folder() as folder:
        copy = folder / f"inner{_PACKAGE}"
        copy.write_bytes(_packaged(package))
        return _listed(str(copy))


def _listed(archive: str) -> list[str]:
    try:
        found = Sdf.ZipFile.Open(archive)
    except UNREADABLE:
        return []
    with reading(archive):
        return [entry for entry in found.GetFileNames() if _is_layer(entry)] if found else []


def _packaged(name: str) -> bytes:
    try:
        asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(name))
    except UNREADABLE:
        return b""
    return bytes(asset.GetBuffer()) if asset else b""


@cache
def _is_format(suffix: str) -> bool:
    return bool(suffix) and Sdf.FileFormat.FindByExtension(suffix) is not None


def _is_layer(path: str) -> bool:
    return _is_format(PurePosixPath(path.rstrip("]")).suffix.lower().lstrip("."))


def _references(layer: Sdf.Layer, facts: Facts, variables: dict[str, object]) -> Iterator[str]:
    """The layers that a layer may make USD open: those of its references that are there."""
    key = layer.identifier, facts, repr(variables)
    if key not in _KNOWN:
        _KNOWN[key] = tuple(_named(layer, variables))
    for file in _KNOWN[key]:
        whole = Sdf.ComputeAssetPathRelativeToLayer(layer, file)
        untrusted.check_path(Path(Ar.SplitPackageRelativePathOuter(whole)[0]))
        found = Ar.GetResolver().Resolve(whole)
        if found:
            yield str(found)


def _named(layer: Sdf.Layer, variables: dict[str, object]) -> Iterator[str]:
    """The layers that a layer names: by its arcs, clips and expressions."""
    with reading(layer.realPath or layer.identifier):
        known = {**dict(layer.expressionVariables), **variables}
        arcs = [_evaluated(path, known, layer) for path in layer.GetCompositionAssetDependencies()]
    try:
        others = list(chain(*UsdUtils.ExtractExternalReferences(layer.identifier)))
    except UNREADABLE:
        others = []
    for path in dict.fromkeys((*arcs, *others)):
        file = Sdf.Layer.SplitIdentifier(path)[0] if path else ""
        if file and _is_layer(file):
            yield file


def _evaluated(path: str, known: dict[str, object], layer: Sdf.Layer) -> str:
    if not Sdf.VariableExpression.IsExpression(path):
        return path
    if _nests_deeply(path.encode("utf-8", "replace")):
        raise _too_deep(layer.realPath or layer.identifier)
    return str(Sdf.VariableExpression(path).Evaluate(known).value or "")


@cache
def _check_depth(name: str, facts: Facts) -> None:
    """Refuse a crate whose prims nest too deeply, without brackets, or are not all there."""
    layer = Sdf.Layer.Find(name)
    if layer.GetFileFormat().formatId == "usda":
        return
    with reading(name):
        level: list[Sdf.PrimSpec] = list(layer.rootPrims)
        for _ in range(MAX_DEPTH):
            if not all(spec and None not in list(spec.properties) for spec in level):
                raise _damaged(name)
            level = [child for spec in level for child in _below(spec)]
            if not level:
                return
    raise _too_deep(name)


def _below(spec: Sdf.PrimSpec) -> Iterator[Sdf.PrimSpec]:
    yield from spec.nameChildren
    if spec.HasInfo("variantSetNames"):
        for variants in spec.variantSets.values():
            yield from (variant.primSpec for variant in variants.variants.values())


def _damaged(place: object) -> InputError:
    return InputError(
        "not a readable USD file: it is damaged, and its contents do not match its header",
        place=place,
        remedy="copy it again, or export it again",
    )


def _too_deep(place: object) -> InputError:
    return InputError(
        f"it nests deeper than {MAX_DEPTH} levels", place=place, remedy="is this the right file?"
    )
