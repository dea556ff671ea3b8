"""How well friction is predicted for materials that were left out.

Every specimen (one look; its rows differ in the counterface) is left out with all its rows, the
counterfaces' factors are fitted anew, and its published coefficients are predicted for their own
counterfaces. Errors are of the static coefficient.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import click
import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from benchmarks.report import publish, table
from openrooms_usd.library.friction import friction_of
from openrooms_usd.library.friction.mapping import BANDWIDTH, Mapping, blended
from openrooms_usd.library.friction.references import (
    SUBSTANCES,
    Reference,
    counterface_factors,
    references,
)

Array = NDArray[Any]

# The paper's floors and cabinet, as they look; nothing is fitted to its numbers.
PAPER: Final = (
    ("wood (varnished board)", "wood", (0.35, 0.20, 0.10), 0.40, 0.76),
    ("carpet (grey-brown)", "fabric", (0.25, 0.22, 0.19), 1.00, 0.76),
    ("wax (wood under a glossy film)", "wood", (0.35, 0.20, 0.10), 0.12, 0.31),
    ("wax (a polish on a floor tile)", "paint", (0.50, 0.48, 0.42), 0.15, 0.31),
)


@dataclass(frozen=True)
class Held:
    """All rows as arrays, and what is left out together."""

    rows: tuple[Reference, ...]
    codes: Array
    substance: Array
    static: Array
    group: Array


def gathered(by_source: bool = False) -> Held:
    """The references, left out by specimen, or by source and substance."""
    rows = references()
    mapping = Mapping(rows)
    keys = [repr((row.substance, row.source) if by_source else row.specimen) for row in rows]
    return Held(
        rows,
        np.stack([mapping.codes(row.substance, row.albedo, row.roughness) for row in rows]),
        np.array([row.substance for row in rows]),
        np.array([row.static for row in rows]),
        np.unique(keys, return_inverse=True)[1],
    )


def errors(held: Held, how: str, codes: Array | None = None) -> tuple[Array, Array]:
    """Predicted minus published, and the standard deviation that is claimed, for every row."""
    seen = held.codes if codes is None else codes
    wrong, claimed = np.empty(len(held.rows)), np.empty(len(held.rows))
    for group in np.unique(held.group):
        out = held.group == group
        kept = tuple(row for row, gone in zip(held.rows, out, strict=True) if not gone)
        factors = counterface_factors(kept) if "counterface" in how else {}
        adjusted = np.array([r.static / factors.get(r.counterface, 1.0) for r in held.rows])
        overall = _mean_of_substances(held.substance[~out], adjusted[~out])
        variation = float(np.std(list(factors.values()))) if factors else 0.0
        for index in np.flatnonzero(out):
            row = held.rows[index]
            alike = ~out & (held.substance == row.substance)
            # Where a source is the only one of a substance, all others stand in.
            known = alike if "substance" in how and alike.any() else ~out
            width = BANDWIDTH if "looks" in how else np.inf
            mean, variance = blended(seen[index], seen[known], adjusted[known], overall, width)
            wrong[index] = mean * factors.get(row.counterface, 1.0) - row.static
            claimed[index] = np.sqrt(variance + (mean * variation) ** 2)
    return wrong, claimed


def _mean_of_substances(substance: Array, adjusted: Array) -> float:
    return float(np.mean([adjusted[substance == s].mean() for s in np.unique(substance)]))


def summary(held: Held, how: str) -> dict[str, Any]:
    """Mean absolute and root mean square error, and how many errors are within the spread."""
    wrong, claimed = errors(held, how)
    return {
        "known": how,
        "mean absolute error": float(np.abs(wrong).mean()),
        "rms error": float(np.sqrt(np.mean(wrong**2))),
        "within the spread": float((np.abs(wrong) <= claimed).mean()),
    }


KNOWN: Final = (
    "nothing",
    "looks",
    "substance",
    "substance, looks",
    "counterface",
    "counterface, looks",
    "counterface, substance",
    "counterface, substance, looks",
)


def gloss(held: Held) -> list[dict[str, Any]]:
    """Roughness against friction: specular means slippery where the correlation is positive."""
    factors = counterface_factors(held.rows)
    adjusted = np.array([row.static / factors[row.counterface] for row in held.rows])
    roughness = np.array([row.roughness for row in held.rows])
    found = []
    for name in ("all", *SUBSTANCES):
        mine = np.full(len(adjusted), True) if name == "all" else held.substance == name
        value = float(spearmanr(roughness[mine], adjusted[mine]).statistic)
        found.append({"substance": name, "rows": int(mine.sum()), "rank correlation": value})
    means = [[x[held.substance == s].mean() for s in SUBSTANCES] for x in (roughness, adjusted)]
    between = float(spearmanr(*means).statistic)
    return [*found, {"substance": "means of the nine", "rows": 9, "rank correlation": between}]


def beside_the_paper() -> list[dict[str, Any]]:
    """What our table says of the paper's three, on the references' mean counterface and rubber."""
    rubber = counterface_factors(references())["rubber"]
    found = []
    for name, substance, albedo, roughness, theirs in PAPER:
        ours = friction_of(substance, albedo, roughness)  # type: ignore[arg-type]
        found.append(
            {
                "material": name,
                "static": float(ours.static),
                "dynamic": float(ours.dynamic),
                "spread": float(ours.spread),
                "static on rubber": float(ours.static) * rubber,
                "paper": theirs,
            }
        )
    return found


def _markdown(rows: list[dict[str, Any]]) -> str:
    return table(list(rows[0]), [list(row.values()) for row in rows])


@click.command(help=__doc__)
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(target: Path | None) -> None:
    specimens, sources = gathered(), gathered(by_source=True)
    data: dict[str, Any] = {
        "left_out": [summary(specimens, how) for how in KNOWN],
        "sources_left_out": [summary(sources, how) for how in KNOWN],
        "gloss": gloss(specimens),
        "paper": beside_the_paper(),
        "counterfaces": counterface_factors(references()),
    }
    faces = [{"counterface": k, "factor": v} for k, v in data["counterfaces"].items()]
    markdown = "\n\n".join(
        [
            "Each specimen left out\n\n" + _markdown(data["left_out"]),
            "Each source left out of a substance\n\n" + _markdown(data["sources_left_out"]),
            "Roughness against friction\n\n" + _markdown(data["gloss"]),
            "Beside the paper\n\n" + _markdown(data["paper"]),
            "Counterfaces\n\n" + _markdown(faces),
        ]
    )
    publish("friction", data, markdown, target)


if __name__ == "__main__":
    main()
