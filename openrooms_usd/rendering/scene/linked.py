"""What of a lamp counts on a surface: UsdLux's light linking, diffuse and specular multipliers."""

from collections.abc import Iterable

from openrooms_usd.rendering.scene.arrays import Patch


def is_linked(patches: Iterable[Patch]) -> bool:
    """Whether there is a lamp that counts more on some surfaces than on others."""
    return any(patch.unlit_by or patch.response != (1.0, 1.0) for patch in patches)


def counted(lamp: Patch, patch: Patch) -> float:
    """The factor of a lamp's light on a surface.

    Args:
        lamp: What emits.
        patch: What receives: the second multiplier is for what is all metal.
    """
    if lamp.lamp in patch.unlit_by:
        return 0.0
    return lamp.response[patch.surface.metallic == 1.0]
