"""Families of all substances: statistics that know no colour and no mean roughness tell them apart.

What is looked at is structure alone: the spectra of brightness and relief over metres, their
directions, the shapes of their histograms, how they go together, how strong they are.
"""

from functools import cache
from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray

from openrooms_usd.description import families
from openrooms_usd.description.substances import Substance
from openrooms_usd.library.textures import FAMILIES, TextureSet, make

Array = NDArray[np.float64]

NAMES = [name for families in FAMILIES.values() for name in families]
RESOLUTION = 128
LEARNT, ASKED = (0, 1), (2,)
# Of the picture's side: what is compared is relative to it, and the side itself.
# One step of eight bits, as a share of a middle brightness.
STEP = 0.01
BANDS = np.geomspace(1.0, RESOLUTION / 2, 13)
WEIGHTS = np.array([0.2126, 0.7152, 0.0722])


def statistics(made: TextureSet) -> Array:
    """(F,) what a material is like, whatever its colour."""
    light = np.log((made.albedo / 255.0) ** 2.2 @ WEIGHTS + 0.01)
    low, high = made.height_range
    relief = low + (high - low) * made.height / 65535.0
    gloss = made.roughness / 255.0
    fields = [light, relief, gloss]
    strengths = [
        np.log(light.std() + 1e-3),
        np.log(relief.std() + 1e-7),
        np.log(slopes(relief, made.size) + 1e-3),
        np.log(gloss.std() + 1e-3),
        np.log(chroma(made) + 1e-3),
    ]
    together = [correlation(a, b) for a, b in [(light, relief), (light, gloss), (relief, gloss)]]
    shapes = [shape for field in fields for shape in histogram(field)]
    spectra = [share for field in ((light, STEP), (relief, 1e-8)) for share in spectrum(*field)]
    return np.array([*strengths, *together, *shapes, *spectra, 3.0 * np.log(made.size)])


def slopes(relief: Array, size: float) -> float:
    texel = size / len(relief)
    return float(np.hypot(*np.gradient(relief, texel)).mean())


def chroma(made: TextureSet) -> float:
    """How much the hue varies: of ratios, so that a tint of the whole falls out."""
    ratios = np.log(made.albedo + 8.0)
    return float((ratios - ratios.mean(axis=-1, keepdims=True)).std(axis=(0, 1)).mean())


def correlation(a: Array, b: Array) -> float:
    return float(((a - a.mean()) * (b - b.mean())).mean() / (a.std() * b.std() + 1e-9))


def histogram(field: Array) -> tuple[float, float]:
    """Skewness and the logarithm of kurtosis."""
    z = (field - field.mean()) / (field.std() + 1e-9)
    return float(np.clip((z**3).mean(), -4, 4)), float(np.log((z**4).mean() + 0.1))


def spectrum(field: Array, floor: float) -> Array:
    """Logarithms of the shares of power in bands of frequency and in directions.

    Args:
        field: The field.
        floor: Standard deviation of what is no more than rounding.
    """
    total_floor = (floor * field.size) ** 2
    power = np.abs(np.fft.fft2(field - field.mean())) ** 2
    f = np.fft.fftfreq(len(field), 1.0 / len(field))
    radius, angle = np.hypot(f[:, None], f), np.arctan2(f[:, None], f) % np.pi
    band = np.digitize(radius, BANDS)
    sector = np.round(angle / np.pi * 8).astype(int) % 8
    # Lines of an exact lattice are told from the spread of a random one by their peak.
    total = power.sum() + total_floor
    peak = power.max() / total
    bands = np.bincount(band.ravel(), power.ravel(), len(BANDS) + 1)
    sectors = np.bincount(sector.ravel(), power.ravel(), 8)
    shares = np.concatenate([bands, sectors]) / total
    return np.concatenate([np.log10(shares + 3e-4), [2.0 * peak]])


@cache
def sample(name: str, number: int) -> Array:
    return statistics(make(name, number, resolution=RESOLUTION))


def told_apart(learnt: Array, asked: Array) -> list[tuple[int, int]]:
    """Pairs (is, taken for) of families of which a material is nearer to another family's mean.

    Args:
        learnt: (families, materials, F).
        asked: (families, materials, F) others of the same families.
    """
    means = learnt.mean(axis=1)
    within = np.sqrt(((learnt - means[:, None]) ** 2).mean(axis=(0, 1))) + 1e-3
    distances = (((asked[:, :, None] - means) / within) ** 2).sum(axis=-1)
    nearest = distances.argmin(axis=-1)
    return [(i, int(j)) for i, row in enumerate(nearest) for j in row if j != i]


def test_every_substance_has_twelve_families() -> None:
    assert set(FAMILIES) == set(get_args(Substance))
    assert {kind: len(families) for kind, families in FAMILIES.items() if len(families) < 12} == {}


def test_names_are_unique_words() -> None:
    assert len(set(NAMES)) == len(NAMES)
    assert all(name.isidentifier() and name == name.lower() for name in NAMES)


@pytest.mark.long
@pytest.mark.slow
def test_families_differ_in_structure() -> None:
    """Materials never seen are recognised among all families, by structure alone."""
    learnt = np.array([[sample(name, number) for number in LEARNT] for name in NAMES])
    asked = np.array([[sample(name, number) for number in ASKED] for name in NAMES])
    assert [(NAMES[a], NAMES[b]) for a, b in told_apart(learnt, asked)] == []


def test_a_recoloured_copy_is_found_out() -> None:
    """Other colours of the same recipe are not taken for another family."""
    dyed = np.array(
        [
            [
                statistics(make("oak_planks", n, color=(0.3, 0.1, 0.2), resolution=RESOLUTION))
                for n in LEARNT
            ]
        ]
    )
    own = np.array([[sample("oak_planks", n) for n in LEARNT]])
    other = np.array([[sample("vinyl_planks", n) for n in LEARNT]])
    apart, copied = np.abs(own - other).mean(), np.abs(own - dyed).mean()
    assert copied < 0.2 * apart
    # As a second family it would be taken for the first, and the test above would say so.
    asked = np.array([[sample("oak_planks", n) for n in ASKED]])
    both = np.concatenate([own, dyed]), np.concatenate([asked, asked])
    assert told_apart(*both) != []


def test_names_are_those_of_the_description() -> None:
    assert {kind: set(names) for kind, names in FAMILIES.items()} == {
        kind: set(names) for kind, names in families.FAMILIES.items()
    }
    assert set(get_args(families.Family)) == set(NAMES)
