"""From a disk to friction: the substance is the prior, references that look alike refine it."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.friction.disks import logarithms, reflectance_disks
from openrooms_usd.library.friction.references import SUBSTANCES, Reference, counterface_factors

# Principal components of the references' log disks that make a code: 98 % of the variance.
COMPONENTS: Final = 3
# How far a reference is heard, in standard deviations of the references' codes.
BANDWIDTH: Final = 1.0
# The substance's mean counts as this many references that look exactly alike.
PRIOR_WEIGHT: Final = 1.0
# The mean of all substances counts as this many references of each: five rows say little.
OVERALL_WEIGHT: Final = 2.0
# The ratio of dynamic to static of all rows counts as this many rows of the substance.
_RATIO_WEIGHT: Final = 2.0

Array = NDArray[np.floating[Any]]


class Friction(NamedTuple):
    """Coulomb coefficients, dry, against the references' average counterface.

    Attributes:
        static: At rest.
        dynamic: While sliding, at most the static one.
        spread: Standard deviation of the static one, for one material on one unknown counterface.
    """

    static: NDArray[np.float64]
    dynamic: NDArray[np.float64]
    spread: NDArray[np.float64]


@dataclass(frozen=True)
class Mapping:
    """Nearest neighbours among reference materials of the same substance.

    Attributes:
        rows: The reference materials.
        bandwidth: See `BANDWIDTH`; infinite makes all references of a substance count alike.
        prior_weight: See `PRIOR_WEIGHT`.
    """

    rows: tuple[Reference, ...]
    bandwidth: float = BANDWIDTH
    prior_weight: float = PRIOR_WEIGHT

    @cached_property
    def factors(self) -> dict[str, float]:
        """What each counterface does."""
        return counterface_factors(self.rows)

    @cached_property
    def _statics(self) -> NDArray[np.float64]:
        """(n,) the published coefficients, brought to the average counterface."""
        return np.array([row.static / self.factors[row.counterface] for row in self.rows])

    @cached_property
    def _by_substance(self) -> list[NDArray[np.float64]]:
        return [self._statics[[row.substance == s for row in self.rows]] for s in SUBSTANCES]

    @cached_property
    def _overall(self) -> float:
        """The mean of the substances, each counted once."""
        return float(np.mean([values.mean() for values in self._by_substance]))

    @cached_property
    def _basis(self) -> tuple[Array, Array]:
        """The mean of the references' log disks, and the axes that whiten their differences."""
        disks = _log_disks(
            np.array([row.albedo for row in self.rows]),
            np.array([row.roughness for row in self.rows]),
            np.array([row.substance == "metal" for row in self.rows], np.float64),
        )
        mean = disks.mean(axis=0)
        _, scale, axes = np.linalg.svd(disks - mean, full_matrices=False)
        deviations = scale[:COMPONENTS] / np.sqrt(len(self.rows))
        return mean, axes[:COMPONENTS].T / deviations

    @cached_property
    def _own_codes(self) -> Array:
        """(n, `COMPONENTS`) of the references."""
        return np.stack([self.codes(r.substance, r.albedo, r.roughness) for r in self.rows])

    def codes(self, substance: Substance, albedo: ArrayLike, roughness: ArrayLike) -> Array:
        """The codes of materials: their log disks along the references' principal components.

        Whitened, so that a highlight of few pixels counts as much as an albedo that moves them all.

        Args:
            substance: Metals reflect by their base colour alone.
            albedo: (..., 3) linear base colour.
            roughness: (...,) perceptual.

        Returns:
            (..., `COMPONENTS`).
        """
        mean, axes = self._basis
        metallic = 1.0 if substance == "metal" else 0.0
        return np.asarray((_log_disks(albedo, roughness, metallic) - mean) @ axes)

    def friction(self, substance: Substance, albedo: ArrayLike, roughness: ArrayLike) -> Friction:
        """The friction of materials.

        Args:
            substance: What the materials are.
            albedo: (..., 3) linear base colour.
            roughness: (...,) perceptual.
        """
        return self.friction_of_codes(substance, self.codes(substance, albedo, roughness))

    def friction_of_codes(self, substance: Substance, codes: Array) -> Friction:
        """The friction of materials by their codes.

        The mean of the substance's references, `blended` by how alike they look. The spread is
        that of the same references about it, and of the counterfaces.

        Args:
            substance: What the materials are.
            codes: (..., `COMPONENTS`) as `codes` gives them.
        """
        mine = np.array([row.substance == substance for row in self.rows])
        known, own = self._statics[mine], self._own_codes[mine]
        static, variance = blended(
            codes, own, known, self._overall, self.bandwidth, self.prior_weight
        )
        spread = np.sqrt(variance + (static * self._counterface_variation) ** 2)
        return Friction(static, static * self._ratio(substance), spread)

    def unknown(self) -> Friction:
        """The friction of an unknown substance: the mean of all substances, and their spread."""
        static = self._overall
        variance = np.mean([np.mean((values - static) ** 2) for values in self._by_substance])
        spread = np.sqrt(variance + (static * self._counterface_variation) ** 2)
        ratio = np.mean([self._ratio(substance) for substance in SUBSTANCES])
        return Friction(*(np.asarray(value) for value in (static, static * ratio, spread)))

    @cached_property
    def _counterface_variation(self) -> float:
        """Relative standard deviation over the counterfaces, each counted once."""
        return float(np.std(list(self.factors.values())))

    def _ratio(self, substance: Substance) -> float:
        """Dynamic by static: the mean of the substance's rows, drawn to that of all rows."""
        ratios = {s: [] for s in SUBSTANCES}  # type: dict[Substance, list[float]]
        for row in self.rows:
            if row.dynamic is not None:
                ratios[row.substance].append(min(row.dynamic / row.static, 1.0))
        overall = float(np.mean([ratio for values in ratios.values() for ratio in values]))
        own = ratios[substance]
        return (sum(own) + _RATIO_WEIGHT * overall) / (len(own) + _RATIO_WEIGHT)


def blended(
    codes: Array,
    own: Array,
    known: Array,
    overall: float,
    bandwidth: float = BANDWIDTH,
    prior_weight: float = PRIOR_WEIGHT,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The mean and variance of references by how alike they look.

    Weighted by exp(-d^2 / 2 h^2), d the distance of codes and h the bandwidth. The result is drawn
    to their plain mean, as by that many more references of the same look. That is drawn to the
    overall mean, as by `OVERALL_WEIGHT` references beside the n known ones.

    Args:
        codes: (..., C) of the materials.
        own: (n, C) of the references.
        known: (n,) the references' coefficients.
        overall: What anything has.
        bandwidth: h; infinite makes all count alike.
        prior_weight: References that the plain mean counts for.

    Returns:
        Mean, and variance of the references about it, each (...,).
    """
    distance2 = np.sum((codes[..., None, :] - own) ** 2, axis=-1)
    # The prior is spread over the references: their plain mean is a mean of them.
    weight = np.exp(-distance2 / (2 * bandwidth**2)) + prior_weight / len(known)
    weight /= weight.sum(axis=-1, keepdims=True)
    trust = len(known) / (len(known) + OVERALL_WEIGHT)
    mean = trust * (weight @ known) + (1.0 - trust) * overall
    variance = np.sum(weight * (known - mean[..., None]) ** 2, axis=-1)
    # Few references know less of their own scatter than many.
    return mean, np.asarray(variance * len(known) / max(len(known) - 1, 1))


def _log_disks(albedo: ArrayLike, roughness: ArrayLike, metallic: ArrayLike) -> Array:
    return logarithms(reflectance_disks(albedo, roughness, metallic))
