"""Views with more lights than the released loaders have room for."""

from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from typing import Final

from openrooms_usd.colorimetry import luminance
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.reading import RenderedScene, RenderedView
from orusd_openrooms.layout import suffix_of
from orusd_openrooms.lights import Light, lights_of

MOST_WINDOWS: Final = 3
MOST_LAMPS: Final = 7
"""IndoorLightEditing's arrays hold so many that are seen in a picture, and as many that are not."""

# A light is seen by it from 25 of its 320x240 pixels on.
_SEEN_SHARE: Final = 25.0 / (320.0 * 240.0)

CROWDED: Final = (
    f"more than {MOST_WINDOWS} windows or {MOST_LAMPS} lamps that are visible, or that are not"
)


def too_many_of(
    splits: Sequence[str], scenes: Sequence[RenderedScene]
) -> list[dict[str, frozenset[int]]]:
    """As `too_many`, of each split; those of a suffix share their views, and the first counts."""
    found: dict[str, dict[str, frozenset[int]]] = {}
    suffixes = [suffix_of(split) for split in splits]
    for suffix, scene in zip(suffixes, scenes, strict=True):
        if suffix not in found:
            found[suffix] = too_many(scene, lights_of(scene))
    return [found[suffix] for suffix in suffixes]


def without(scene: RenderedScene, crowded: Container[str]) -> RenderedScene:
    """A render without its crowded views.

    Raises:
        InputError: None is left.
    """
    views = {name: view for name, view in scene.views.items() if name not in crowded}
    if not views:
        raise InputError(
            f"all of its views have {CROWDED}",
            place=scene.folder,
            remedy="crowded: drop (--crowded drop) leaves out the weakest lights, keep keeps all",
        )
    return replace(scene, views=views)


def too_many(scene: RenderedScene, lights: Sequence[Light]) -> dict[str, frozenset[int]]:
    """The lights of each view that find no place: the smallest in the picture, then the faintest.

    Args:
        scene: A finished render; one without the channel ``mask_i`` has no boxes of lights either.
        lights: Those of it that have a place.

    Returns:
        Their numbers by the view's name; views that are not crowded are left out.

    Raises:
        InputError: A file is damaged.
    """
    windows = sum(light.is_window for light in lights)
    if windows <= MOST_WINDOWS and len(lights) - windows <= MOST_LAMPS:
        return {}
    found = {view.name: _without_place(view, lights) for view in scene.each()}
    return {name: numbers for name, numbers in found.items() if numbers}


def _without_place(view: RenderedView, lights: Sequence[Light]) -> frozenset[int]:
    masks = view.lights.get("mask", {})
    shares = {
        light.number: float(masks[light.number].mean()) for light in lights if light.number in masks
    }
    beyond: set[int] = set()
    for is_window, most in ((True, MOST_WINDOWS), (False, MOST_LAMPS)):
        for seen in (True, False):
            group = [
                light
                for light in lights
                if light.is_window == is_window
                and light.number in shares
                and (shares[light.number] > _SEEN_SHARE) == seen
            ]
            group.sort(key=lambda light: _worth(light, shares), reverse=True)
            beyond |= {light.number for light in group[most:]}
    return frozenset(beyond)


def _worth(light: Light, shares: Mapping[int, float]) -> tuple[float, float]:
    """What a light takes of the picture, then about what it sends into the room."""
    largest = sorted(light.size)[-2:]
    return shares[light.number], float(luminance(light.radiance)) * largest[0] * largest[1]
