"""Which assets a room needs: one for each distinct object, however often it stands there."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any, Final

import numpy as np

from openrooms_usd.description.furniture import FileObject, LibraryObject
from openrooms_usd.furniture import (
    CATEGORIES,
    NOTHING_ORDERED,
    FitOptions,
    Size,
    category,
    check,
    make,
    module_of,
    styles,
)
from openrooms_usd.library.assets import Asset, Model, model_of, read_asset
from openrooms_usd.library.models.meshfile import read_model
from openrooms_usd.library.models.posture import Usual
from openrooms_usd.steps.base import StepContext, file_digest

# What every piece of furniture runs, beside its category's module.
_MAKERS: Final = ("openrooms_usd.draws", "openrooms_usd.furniture")


def asked(item: LibraryObject) -> tuple[Size, FitOptions]:
    """The size of an object of a description, and how its fronts are ordered."""
    spec = category(item.category)
    style = spec.styles.get(item.style or "")
    size = item.size or (style and style.size) or spec.size
    return size, FitOptions(item.fronts, item.cutouts)


@dataclass
class Catalogue:
    """Makes each distinct asset once.

    Attributes:
        context: The step's context: its seed draws styles and details.
    """

    context: StepContext
    _assets: dict[tuple[Any, ...], Asset] = field(default_factory=dict)
    _drawn: dict[tuple[str, Size], str] = field(default_factory=dict)

    def furniture(
        self,
        name: str,
        size: Size,
        style: str | None = None,
        label: str | None = None,
        order: FitOptions = NOTHING_ORDERED,
    ) -> Asset:
        """Furniture of the library. Pieces of one category, size and style are the same asset.

        Args:
            name: The category to build, or a stand-in.
            size: Its box, metres.
            style: One of the category's styles; drawn once for its size when None.
            label: What it shall be called; by default its category.
            order: What is ordered with it.

        Raises:
            InputError: The library has no such category or style, or it cannot be ordered so.
        """
        if style is None:
            style = self._drawn.get((name, size)) or self._draw(name, size)
        else:
            check(name, size, style, order)
        draws = ("alignment", "details", name, repr(size), style)
        rng = partial(self.context.rng, *draws)
        key: tuple[Any, ...] = (name, *size, style, self.context.room.seed, *draws)
        key = key if order == NOTHING_ORDERED else (*key, repr(order))
        code = (*_MAKERS, module_of(name))
        return self._asset(
            label or name, key, lambda: model_of(make(name, size, style, rng(), order)), code
        )

    def _draw(self, name: str, size: Size) -> str:
        choices = styles(name, size)
        draw = self.context.rng("alignment", "style", name, repr(size))
        return self._drawn.setdefault((name, size), choices[int(draw.integers(len(choices)))])

    def file(self, item: FileObject, *, scaled: bool = False) -> Asset:
        """The user's own mesh.

        Args:
            item: The file, and how it stands.
            scaled: Whether it is placed with a scale, so that its own size says nothing.

        Raises:
            InputError: The file is missing, unreadable or not a mesh.
            MissingPackageError: Its format needs a package that is not installed.
        """
        path = self.context.input(item.file)
        how = (item.file, item.size, item.up, item.front, item.unit)
        if (known := self._assets.get((item.category, *how))) is not None:
            return known
        model = read_model(
            path,
            size=item.size,
            up=item.up,
            front=item.front,
            unit=item.unit,
            usual=None if scaled else _usual(item.category),
        )
        self.context.notes.extend(f"{item.file}: {note}" for note in model.notes)
        key = (file_digest(path), *how[1:], _model_digest(model))
        asset = self._asset(item.category, key, lambda: model)
        self._assets[item.category, *how] = asset
        return asset

    def _asset(
        self,
        label: str,
        key: tuple[Any, ...],
        build: Callable[[], Model],
        code: tuple[str, ...] = (),
    ) -> Asset:
        return self._assets.setdefault((label, *key), Asset(label, key, cache(build), code))


def _usual(name: str) -> Usual | None:
    """The usual sizes of a category that the library has."""
    if name not in CATEGORIES:
        return None
    built = category(name)
    return Usual(name, built.size, built.min_size, built.max_size)


def _model_digest(model: Model) -> str:
    """A hash of all of a model that an asset holds, pictures too.

    The file alone does not determine them, because it may refer to others.
    """
    plain = (model.licence, sorted(model.titles.items()), model.double_sided, model.joints)
    digest = hashlib.sha256(f"{plain!r}\n".encode())
    for part, mesh in model.parts.items():
        for name, values in vars(mesh).items():
            digest.update(f"{part} {name} {None if values is None else values.shape}\n".encode())
            digest.update(b"" if values is None else np.ascontiguousarray(values).tobytes())
    for part, surface in model.surfaces.items():
        for name, value in vars(surface).items():
            file = getattr(value, "file", None)
            content = hashlib.sha256(read_asset(file)).hexdigest() if file else repr(value)
            digest.update(f"{part} {name} {content}\n".encode())
    return digest.hexdigest()
