"""How well friction is predicted for materials that were left out, and where gloss misleads.

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


def chance(held: Held, rounds: int) -> float:
    """How often looks dealt out at random among a substance's specimens do as well as the real."""
    best = KNOWN[-1]
    real = np.abs(errors(held, best)[0]).mean()
    rng = np.random.default_rng(0)
    as_good = 0
    for _ in range(rounds):
        dealt = held.codes.copy()
        for substance in SUBSTANCES:
            of = np.unique(held.group[held.substance == substance])
            for group, other in zip(of, rng.permutation(of), strict=True):
                dealt[held.group == group] = held.codes[held.group == other][0]
        as_good += np.abs(errors(held, best, dealt)[0]).mean() <= real
    return (as_good + 1) / (rounds + 1)


def rank_correlation(a: Array, b: Array) -> float:
    """Spearman's, ties by their mean rank."""
    ranks = [np.array([np.mean(np.flatnonzero(np.sort(x) == v)) for v in x]) for x in (a, b)]
    centred = [rank - rank.mean() for rank in ranks]
    norm = np.sqrt(np.prod([np.sum(rank**2) for rank in centred]))
    return float(np.sum(centred[0] * centred[1]) / norm) if norm > 0 else float("nan")


def gloss(held: Held) -> list[dict[str, Any]]:
    """Roughness against friction: specular means slippery where the correlation is positive."""
    factors = counterface_factors(held.rows)
    adjusted = np.array([row.static / factors[row.counterface] for row in held.rows])
    roughness = np.array([row.roughness for row in held.rows])
    found = []
    for name in ("all", *SUBSTANCES):
        mine = np.full(len(adjusted), True) if name == "all" else held.substance == name
        value = rank_correlation(roughness[mine], adjusted[mine])
        found.append({"substance": name, "rows": int(mine.sum()), "rank correlation": value})
    means = [[x[held.substance == s].mean() for s in SUBSTANCES] for x in (roughness, adjusted)]
    between = rank_correlation(*map(np.array, means))
    return [*found, {"substance": "means of the nine", "rows": 9, "rank correlation": between}]


def misled(held: Held, count: int = 8) -> list[dict[str, Any]]:
    """Where looks alone, without the substance, are most wrong."""
    wrong, _ = errors(held, "counterface, looks")
    with_substance, _ = errors(held, KNOWN[-1])
    worst = np.argsort(-np.abs(wrong))[:count]
    return [
        {
            "material": held.rows[i].name,
            "roughness": held.rows[i].roughness,
            "published": held.rows[i].static,
            "by looks": float(held.static[i] + wrong[i]),
            "by substance and looks": float(held.static[i] + with_substance[i]),
        }
        for i in worst
    ]


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
@click.option("--rounds", type=int, default=200, help="Random deals of looks.")
@click.option("--quick", is_flag=True, help="Five random deals.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(rounds: int, quick: bool, target: Path | None) -> None:
    specimens, sources = gathered(), gathered(by_source=True)
    p = chance(specimens, 5 if quick else rounds)
    data: dict[str, Any] = {
        "left_out": [summary(specimens, how) for how in KNOWN],
        "sources_left_out": [summary(sources, how) for how in KNOWN],
        "chance": p,
        "gloss": gloss(specimens),
        "misled": misled(specimens),
        "paper": beside_the_paper(),
        "counterfaces": counterface_factors(references()),
    }
    faces = [{"counterface": k, "factor": v} for k, v in data["counterfaces"].items()]
    markdown = "\n\n".join(
        [
            "Each specimen left out\n\n" + _markdown(data["left_out"]),
            "Each source left out of a substance\n\n" + _markdown(data["sources_left_out"]),
            f"Looks dealt out at random do as well in {p:.0%} of the deals.",
            "Roughness against friction\n\n" + _markdown(data["gloss"]),
            "Where looks alone mislead most\n\n" + _markdown(data["misled"]),
            "Beside the paper\n\n" + _markdown(data["paper"]),
            "Counterfaces\n\n" + _markdown(faces),
        ]
    )
    publish("friction", data, markdown, target)


if __name__ == "__main__":
    main()
