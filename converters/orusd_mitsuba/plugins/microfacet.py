"""OpenRooms' reflectance model: a Lambertian part and a GGX lobe, as functions of cosines.

The model is that of the OpenRooms paper (Li et al., CVPR 2021), which is Karis' of 2013: with A the
albedo, R the roughness, h the half vector, and the cosines n.v, n.l, n.h, v.h

    f = A / pi + D F G / (4 (n.l)(n.v)),        D = R^4 / (pi ((n.h)^2 (R^4 - 1) + 1)^2),
    F = F0 + (1 - F0) 2^((-5.55473 (v.h) - 6.98316)(v.h)),
    G = G1(n.v) G1(n.l),   G1(c) = c / (c (1 - k) + k),   k = (R + 1)^2 / 8.

It is kept as it was published. The lobe alone never reflects more light than it gets, but nothing
is taken from the diffuse part for it. So with F0 = 0.05 the sum reflects more than it gets where A
is above 1 - s. s is the most that the lobe reflects: 0.16 at R = 0.01 (80 degrees off the normal),
0.14 at 0.1, 0.09 at 0.3, 0.06 at 0.5 to 0.7, 0.05 at 1. Albedos found indoors end at about 0.85,
and paths after a bounded number of scatterings: nothing is clipped.

Two ways of writing avoid what breaks in single precision. The denominator of D is
sin^2 + R^4 cos^2, its sine from the components of h: the published form cancels, and is infinite at
R = 0.01. G is written without its numerator, which n.l and n.v cancel: finite at grazing angles.

Directions are in a frame with the normal along z. Everything works on numbers of the active Mitsuba
variant, one at a time or many.
"""

from typing import Any, Final

import drjit as dr
import mitsuba as mi

# Smoother surfaces are taken as this: alpha = 1e-4 is what single precision resolves of h.
LEAST_ROUGHNESS: Final = 0.01


def distribution(h: Any, roughness: Any) -> Any:
    """D of a unit half vector."""
    alpha_squared = _alpha(roughness) ** 2
    spread = h.x * h.x + h.y * h.y + alpha_squared * h.z * h.z
    return alpha_squared / (dr.pi * spread * spread)


def fresnel(f0: Any, cosine: Any) -> Any:
    """F, a number or a colour as ``f0`` is."""
    return f0 + (1.0 - f0) * dr.exp2((-5.55473 * cosine - 6.98316) * cosine)


def visibility(n_v: Any, n_l: Any, roughness: Any) -> Any:
    """G / (4 (n.l)(n.v)); below the horizon as at it."""
    k = _k(roughness)
    n_v, n_l = dr.maximum(n_v, 0.0), dr.maximum(n_l, 0.0)
    return 0.25 / ((n_v * (1.0 - k) + k) * (n_l * (1.0 - k) + k))


def specular(wi: Any, wo: Any, roughness: Any, f0: Any) -> Any:
    """The lobe D F G / (4 (n.l)(n.v)) of two directions on the normal's side."""
    h = dr.normalize(wi + wo)
    shape = distribution(h, roughness) * visibility(wi.z, wo.z, roughness)
    return fresnel(f0, dr.dot(wi, h)) * shape


def sample_lobe(wi: Any, roughness: Any, sample: Any) -> Any:
    """A direction by the visible normals of GGX.

    Dupuy and Benyoub 2023, "Sampling visible GGX normals with spherical caps". It may point below
    the horizon, which is worth nothing.

    Args:
        wi: Where the light goes.
        roughness: Perceptual roughness R.
        sample: Two uniform numbers.
    """
    alpha = _alpha(roughness)
    stretched = dr.normalize(mi.Vector3f(alpha * wi.x, alpha * wi.y, wi.z))
    sine, cosine = dr.sincos(2.0 * dr.pi * sample.x)
    z = dr.fma(1.0 - sample.y, 1.0 + stretched.z, -stretched.z)
    radius = dr.safe_sqrt(1.0 - z * z)
    cap = mi.Vector3f(radius * cosine, radius * sine, z) + stretched
    h = dr.normalize(mi.Vector3f(alpha * cap.x, alpha * cap.y, dr.maximum(cap.z, 1e-20)))
    return 2.0 * dr.dot(wi, h) * h - wi


def lobe_density(wi: Any, wo: Any, roughness: Any) -> Any:
    """Density over solid angle of `sample_lobe`."""
    h = dr.normalize(wi + wo)
    return 0.5 * distribution(h, roughness) / (wi.z + _stretch(wi.z, roughness))


def lobe_narrowness(roughness: Any) -> Any:
    """The part of the lobe's light that `sample_lobe` is better for than Lambert's directions.

    At R = 1 D is constant and the lobe as wide as the hemisphere, where a mirrored direction is
    often lost below the horizon. A fifth stays, for Fresnel's peak at the opposite horizon.
    """
    return 1.0 - 0.8 * _alpha(roughness) ** 2


def lobe_width(roughness: Any) -> Any:
    """About the standard deviation of mirrored directions, radian: twice that of the slopes."""
    return dr.minimum(2.0 * _alpha(roughness), 1.0)


def lobe_albedo(n_v: Any, roughness: Any, f0: Any) -> Any:
    """About what the lobe reflects of even light, to choose between it and the diffuse part.

    `sample_lobe` weighs a sample by F G1(n.v) G1(n.l) over Smith's masking of GGX; here the sample
    is replaced by one direction of the mean slope. Within 12 % in the mean and a factor of 1.7 over
    all angles and roughnesses, by numerical integration.
    """
    k, alpha = _k(roughness), _alpha(roughness)
    n_l = dr.sqrt(dr.lerp(n_v * n_v, 0.5, alpha))
    sines = dr.safe_sqrt((1.0 - n_v * n_v) * (1.0 - n_l * n_l))
    v_h = dr.safe_sqrt(0.5 * (1.0 + n_v * n_l - sines))
    masking = 0.5 * (n_v + _stretch(n_v, roughness)) / (n_v * (1.0 - k) + k)
    seen = n_l / (n_l * (1.0 - k) + k)
    return fresnel(f0, v_h) * masking * seen * (1.0 - 0.5 * alpha)


def _alpha(roughness: Any) -> Any:
    return dr.maximum(roughness, LEAST_ROUGHNESS) ** 2


def _k(roughness: Any) -> Any:
    return (dr.maximum(roughness, LEAST_ROUGHNESS) + 1.0) ** 2 / 8.0


def _stretch(cosine: Any, roughness: Any) -> Any:
    """The root in Smith's masking of GGX: 1 at the normal, alpha at the horizon."""
    alpha_squared = _alpha(roughness) ** 2
    return dr.sqrt(dr.lerp(cosine * cosine, 1.0, alpha_squared))
