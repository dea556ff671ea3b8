"""Materials: how well the reflectance model is sampled, and what leaving it costs.

sampling: the variance of one sample times its seconds, for the integral of our model times a light
over the hemisphere. Directions are drawn by our BSDF, by Mitsuba's `principled` with the same
inputs, and evenly; the last two are given in multiples of ours, so that 10 is ten times the time
to the same noise. The variances are integrals themselves, of the squared integrand over each
density, and are estimated on our samples. Light is even, or comes from every other cell of 30 x 30
degrees.

albedo: what a surface of base colour 0.5 reflects of even light, by our model and by the
UsdPreviewSurface with ior 1.576 that stands for it elsewhere; and how far our sampling is from an
integral in double precision.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from benchmarks.report import publish, table
from openrooms_usd.arrays import Array
from openrooms_usd.usd.shading.surfaces import ior_of

ROUGHNESSES: Final = (0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
# Cosines of the view: along the normal, and grazing.
VIEWS: Final = {"normal": 0.98, "grazing": 0.15}
COSINES: Final = (1.0, 0.7, 0.4, 0.2, 0.1)
F0: Final = 0.05
BASE: Final = 0.5


@dataclass(frozen=True)
class Section:
    """A part of the benchmark: numbers for programs, and text for people."""

    data: Any
    markdown: str


@click.command(help=__doc__)
@click.option("--section", "chosen", multiple=True, help="Repeatable; all by default.")
@click.option("--quick", is_flag=True, help="Few samples, few materials.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(chosen: tuple[str, ...], quick: bool, target: Path | None) -> None:
    sections = {name: SECTIONS[name](quick) for name in chosen or SECTIONS}
    text = "\n\n".join(f"## {name}\n\n{section.markdown}" for name, section in sections.items())
    publish("materials", {name: section.data for name, section in sections.items()}, text, target)


# Sampling.


def sampling(quick: bool) -> Section:
    """Variance at equal time."""
    surfaces = _Surfaces(1 << (14 if quick else 21))
    rows = [
        {
            "metallic": metallic,
            "roughness": R,
            "view": view,
            "light": light,
            **surfaces.compared((R, metallic), cosine, light),
        }
        for metallic in (0.0, 1.0)
        for R in (ROUGHNESSES[::3] if quick else ROUGHNESSES)
        for view, cosine in VIEWS.items()
        for light in ("even", "cells")
    ]
    titles = (
        "metallic",
        "roughness",
        "view",
        "light",
        "ours: variance x ns",
        "principled",
        "uniform",
    )
    return Section(rows, table(titles, [list(row.values()) for row in rows]))


class _Surfaces:
    """Our BSDF and its stand-in, many directions at a time.

    Args:
        count: Directions.
    """

    def __init__(self, count: int) -> None:
        from openrooms_usd.errors import RenderError
        from orusd_mitsuba import variants

        backend = variants.choose()
        if backend.variant.startswith("scalar"):
            remedy = variants.vectorized_remedy()
            raise RenderError("sampling is measured on many directions", remedy=remedy)
        import drjit as dr
        import mitsuba as mi

        from orusd_mitsuba.plugins import openrooms_bsdf, preview_bsdf

        mi.set_variant(backend.variant)
        openrooms_bsdf.register(backend.variant)
        preview_bsdf.register(backend.variant)
        self._dr, self._mi, self._count = dr, mi, count
        rng = np.random.default_rng(1)
        self._which = mi.Float(rng.random(count, dtype=np.float32))
        self._where = mi.Point2f(rng.random((2, count), dtype=np.float32))
        self._context = mi.BSDFContext()

    def ours(self, roughness: float, metallic: float = 0.0) -> Any:
        return self._load("openrooms", roughness, metallic, f0=F0)

    def preview(self, roughness: float, metallic: float = 0.0) -> Any:
        return self._load("usd_preview", roughness, metallic, f0=F0)

    def principled(self, roughness: float, metallic: float = 0.0) -> Any:
        return self._load("principled", roughness, metallic, eta=ior_of(F0))

    def _load(self, kind: str, roughness: float, metallic: float, **inputs: float) -> Any:
        color = {"type": "rgb", "value": [BASE] * 3}
        inputs |= {"roughness": roughness, "metallic": metallic}
        return self._mi.load_dict({"type": kind, "base_color": color, **inputs})

    def compared(self, inputs: tuple[float, float], cosine: float, light: str) -> dict[str, float]:
        """Variance times time: ours in nanoseconds, the others in multiples of it."""
        dr, mi = self._dr, self._mi
        ours, other, si = self.ours(*inputs), self.principled(*inputs), self.seen(cosine)
        bs, weight = ours.sample(self._context, si, self._which, self._where)
        L = self._light(bs.wo, light)
        value, p = weight.x * bs.pdf * L, bs.pdf
        densities = {
            "ours": p,
            "principled": other.pdf(self._context, si, bs.wo),
            "uniform": mi.Float(0.5 / np.pi),
        }
        mean = self._mean(weight.x * L)
        result = {}
        for name, q in densities.items():
            squares = dr.select(p > 0, value * value / (dr.maximum(q, 1e-12) * p), 0.0)
            variance = self._mean(squares) - mean**2
            result[name] = max(variance, 0.0) / mean**2 * self._nanoseconds(name, ours, other, si)
        ratios = {name: result[name] / result["ours"] for name in ("principled", "uniform")}
        return {"ours": result["ours"], **ratios}

    def _nanoseconds(self, name: str, ours: Any, other: Any, si: Any) -> float:
        """What one direction and its value take."""
        mi, context = self._mi, self._context

        def draw() -> Any:
            if name == "ours":
                return ours.sample(context, si, self._which, self._where)
            if name == "principled":
                bs, _ = other.sample(context, si, self._which, self._where)
                return bs.pdf, ours.eval(context, si, bs.wo)
            return ours.eval(context, si, mi.warp.square_to_uniform_hemisphere(self._where))

        times = []
        for _ in range(4):  # the first compiles
            began = time.perf_counter()
            self._dr.eval(draw())
            self._dr.sync_thread()
            times.append(time.perf_counter() - began)
        return 1e9 * min(times[1:]) / self._count

    def albedo(self, bsdf: Any, cosine: float) -> float:
        """What it reflects of even light."""
        weights = bsdf.sample(self._context, self.seen(cosine), self._which, self._where)[1]
        return self._mean(weights.x)

    def seen(self, cosine: float) -> Any:
        mi, si = self._mi, self._dr.zeros(self._mi.SurfaceInteraction3f)
        si.n = mi.Normal3f(0, 0, 1)
        si.sh_frame = mi.Frame3f(si.n)
        # Opaque to the compiler, as a ray's direction is.
        si.wi = self._dr.opaque(mi.Vector3f, 0.0) + mi.Vector3f(*_direction(cosine).tolist())
        return si

    def _light(self, wo: Any, kind: str) -> Any:
        if kind == "even":
            return self._mi.Float(1.0)
        dr, step = self._dr, np.pi / 6
        cells = dr.floor(dr.atan2(wo.y, wo.x) / step) + dr.floor(dr.safe_acos(wo.z) / step)
        return dr.select(cells - 2 * dr.floor(cells / 2) > 0.5, 2.0, self._mi.Float(0.0))

    def _mean(self, values: Any) -> float:
        return float(np.array(values, dtype=np.float64).mean())


def _direction(cosine: float) -> Array:
    return np.array([np.sqrt(1.0 - cosine**2), 0.0, cosine])


# Directional albedo.


def albedo(quick: bool) -> Section:
    """What is lost by leaving our model, and the error of our sampling."""
    surfaces = _Surfaces(1 << (14 if quick else 21))
    rows = []
    for metallic in (0.0, 1.0):
        for R in ROUGHNESSES[::3] if quick else ROUGHNESSES:
            ours, preview = surfaces.ours(R, metallic), surfaces.preview(R, metallic)
            for cosine in COSINES:
                a, b = (surfaces.albedo(bsdf, cosine) for bsdf in (ours, preview))
                exact = BASE * (1 - metallic) + _lobe(R, cosine, F0 + (BASE - F0) * metallic)
                rows.append(
                    {
                        "metallic": metallic,
                        "roughness": R,
                        "cosine": cosine,
                        "ours": a,
                        "preview": b,
                        "error": a / exact - 1,
                    }
                )
    worst = max(abs(row["error"]) for row in rows)
    wide = [
        [
            m,
            R,
            *(
                f"{r['ours']:.3f} {r['preview'] - r['ours']:+.3f}"
                for r in rows
                if (r["metallic"], r["roughness"]) == (m, R)
            ),
        ]
        for m, R in dict.fromkeys((r["metallic"], r["roughness"]) for r in rows)
    ]
    titles = ("metallic", "roughness", *(f"cos {c:g}: ours, preview - ours" for c in COSINES))
    said = f"Largest relative error of our sampling against quadrature: {worst:.2g}."
    return Section({"rows": rows, "largest_error": worst}, f"{table(titles, wide)}\n\n{said}")


def _lobe(R: float, cosine: float, f0: float, steps: int = 800) -> float:
    """The published lobe's integral over the hemisphere, by the midpoint rule over half vectors."""
    u, azimuth = np.meshgrid(*[(np.arange(steps) + 0.5) / steps] * 2)
    tangent, v = R**2 * np.sqrt(u / (1 - u)), _direction(cosine)
    n_h = 1 / np.sqrt(1 + tangent**2)
    v_h = tangent * n_h * np.cos(2 * np.pi * azimuth) * v[0] + n_h * v[2]
    n_l = 2 * v_h * n_h - cosine
    k = (R + 1) ** 2 / 8
    F = (1 - f0) * 2.0 ** ((-5.55473 * v_h - 6.98316) * v_h) + f0
    G = cosine / (cosine * (1 - k) + k) * n_l / (n_l * (1 - k) + k)
    # D n_h times the solid angle of half vectors is du d(azimuth) / 2 pi.
    values = np.where((v_h > 0) & (n_l > 0), F * G * v_h / (cosine * n_h), 0.0)
    return float(values.mean())


SECTIONS: Final[dict[str, Callable[[bool], Section]]] = {"sampling": sampling, "albedo": albedo}

if __name__ == "__main__":
    main()
