"""Under which terms the assets and the textures of a stage may be used."""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from pxr import Kind, Sdf, Usd, UsdShade

from openrooms_usd import names, untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.usd.files.diagnostics import reading

# Files that are pictures, also inside a package.
_PICTURE: Final = re.compile(
    r"\.(png|jpe?g|exr|hdr|tiff?|tga|bmp|webp|ktx2?|dds|avif|tx)\]?$", re.IGNORECASE
)
_KEYS: Final = (names.LICENCE_KEY, "licence")
_SPDX: Final = re.compile(r"SPDX-License-Identifier:\s*(\S[^\r\n]*)")

_Kind = Literal["asset", "texture"]
_Counts = Counter[tuple[str, _Kind, str]]


@dataclass(frozen=True, order=True)
class Licence:
    """What may be done with one asset or texture of a stage.

    Attributes:
        licence: Its terms; ``unknown`` if not stated.
        kind: What it is.
        name: The asset's name, or the texture's file, relative to the stage's folder.
        prims: How many prims show the asset or look up the texture.
    """

    licence: str
    kind: _Kind
    name: str
    prims: int

    @property
    def is_unknown(self) -> bool:
        """Whether its terms are not stated."""
        return self.licence == names.UNKNOWN_LICENCE


def licences(stage: Usd.Stage) -> list[Licence]:
    """The terms of every asset and of every texture of a stage, sorted.

    An asset is what is published as one: it has a name or terms in its ``assetInfo``, or is a
    component that is referenced. A texture has the terms of the nearest prim that states some,
    from its shader up to the asset that it came with, or else those in a file ``NAME.license``
    beside it (the convention of REUSE).

    Raises:
        InputError: The stage holds what cannot be read at all.
    """
    home = str(stage.GetRootLayer().realPath).rpartition("/")[0] + "/"
    with reading(stage.GetRootLayer().realPath):
        counts = _below(stage.GetPseudoRoot(), "", {})
    return sorted(
        Licence(terms, kind, name.removeprefix(home), count)
        for (terms, kind, name), count in counts.items()
    )


def _below(prim: Usd.Prim, terms: str, known: dict[tuple[Sdf.Path, str], _Counts]) -> _Counts:
    """What lies below a prim, under the terms that hold there."""
    key = (prim.GetPrototype().GetPath(), terms) if prim.IsInstance() else None
    if key in known:
        return known[key]
    counts: _Counts = Counter()
    for child in prim.GetFilteredChildren(Usd.TraverseInstanceProxies()):
        inner = _own_terms(child) or terms
        counts.update(_own(child, inner))
        counts.update(_below(child, inner, known))
    if key:
        known[key] = counts
    return counts


def _own(prim: Usd.Prim, terms: str) -> Iterator[tuple[str, _Kind, str]]:
    if _is_asset(prim):
        name = prim.GetAssetInfo().get("name") or prim.GetName()
        yield _own_terms(prim) or names.UNKNOWN_LICENCE, "asset", str(name)
    for file in _pictures(prim):
        yield terms or _beside(file) or names.UNKNOWN_LICENCE, "texture", file


def _is_asset(prim: Usd.Prim) -> bool:
    if prim.IsA(UsdShade.Material) or prim.IsA(UsdShade.Shader) or _emits_only(prim):
        return False
    info = prim.GetAssetInfo()
    if "name" in info or "identifier" in info or _own_terms(prim):
        return True
    return bool(Usd.ModelAPI(prim).IsKind(Kind.Tokens.component) and prim.HasAuthoredReferences())


def _emits_only(prim: Usd.Prim) -> bool:
    """Whether a prim is a light: its terms are those of its picture."""
    return bool(prim.GetAttribute("inputs:texture:file"))


def _own_terms(prim: Usd.Prim) -> str:
    """The terms that a prim states itself; empty where it states none."""
    info = prim.GetAssetInfo()
    return next((str(info[key]) for key in _KEYS if info.get(key)), "")


def _pictures(prim: Usd.Prim) -> Iterator[str]:
    """The files of the pictures that a prim names, as far as they are found; else their names."""
    for attribute in prim.GetAuthoredAttributes():
        if attribute.GetTypeName() != Sdf.ValueTypeNames.Asset:
            continue
        asset = attribute.Get()
        file = str(asset.resolvedPath or asset.path) if asset else ""
        if _PICTURE.search(file):
            yield file


def _beside(file: str) -> str:
    sidecar = Path(f"{file}.license")
    try:
        text = untrusted.read_text(sidecar) if "[" not in file else ""
    except InputError:
        return ""
    found = _SPDX.search(text)
    return (found[1] if found else text.strip().partition("\n")[0]).strip()
