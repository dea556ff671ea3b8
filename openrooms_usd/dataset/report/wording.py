"""Numbers as people read them: few digits, units that fit."""

from typing import Final

_THOUSAND: Final = 1000.0
_COUNTS: Final = ((1e9, "G"), (1e6, "M"), (1e3, "k"))
_BYTES: Final = ((1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB"))
_SECONDS: Final = ((86400.0, "days"), (3600.0, "h"), (60.0, "min"))
# From how many of the next larger unit on it is used: 90 s stay seconds.
_LEAST: Final = 2.0
_LEAST_PERCENT: Final = 0.1


def count(value: float) -> str:
    """Such as ``1.2 M``; small whole numbers stay as they are."""
    if value < 10 * _THOUSAND:
        return f"{value:,.0f}"
    return _in_units(value, _COUNTS, 1.0)


def size(value: float) -> str:
    """Bytes, such as ``27 MB``."""
    return _in_units(value, _BYTES, 1.0) if value >= _THOUSAND else f"{value:.0f} bytes"


def seconds(value: float) -> str:
    """Such as ``0.12 s`` or ``3.5 h``."""
    if value >= _LEAST * _SECONDS[-1][0]:
        return _in_units(value, _SECONDS, _LEAST)
    return f"{digits(value, 2 if value < 10.0 else 3)} s"


def share(part: float, whole: float) -> str:
    """Such as ``12 %`` or ``3.1 %``."""
    percent = 100.0 * part / whole if whole else 0.0
    if 0.0 < percent < _LEAST_PERCENT:
        return f"under {_LEAST_PERCENT} %"
    return f"{percent:.0f} %" if percent >= 10.0 or percent == 0.0 else f"{percent:.1f} %"


def digits(value: float, most: int = 3) -> str:
    """With so many significant digits, never as a power of ten."""
    rounded = float(f"{value:.{most}g}")
    return f"{rounded:,.0f}" if abs(rounded) >= 10 ** (most - 1) else f"{rounded:.12g}"


def _in_units(value: float, units: tuple[tuple[float, str], ...], least: float) -> str:
    for one, name in units:
        if value >= least * one:
            return f"{digits(value / one)} {name}"
    return digits(value)
