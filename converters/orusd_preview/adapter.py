"""What is registered as an entry point."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from openrooms_usd.errors import InputError
from openrooms_usd.rendering.contract import NO_OPTIONS

if TYPE_CHECKING:
    from openrooms_usd.rendering.scene.arrays import Scene
    from orusd_preview.session import PreviewSession

_REACH_METRES: Final = "0.6"


class PreviewRenderer:
    """Shows what is there, and how near things are to each other, without any light of the scene.

    It needs nothing but the core's ray caster, and looks the same by day and by night.
    """

    channels: Final = ("radiance",)

    options: Final[Mapping[str, str]] = {
        "reach": f"how far ambient occlusion looks for what is near, metres; {_REACH_METRES}"
    }

    def open(self, scene: "Scene", options: Mapping[str, str] = NO_OPTIONS) -> "PreviewSession":
        """Make what renders a scene.

        Args:
            scene: The translated stage.
            options: See `options`.

        Raises:
            InputError: The reach is not a positive number.
        """
        from orusd_preview.session import PreviewSession

        return PreviewSession(scene, _metres(options.get("reach", _REACH_METRES)))


def _metres(text: str) -> float:
    try:
        found = float(text)
    except (TypeError, ValueError):
        found = 0.0
    if not 0.0 < found < 1e6:
        raise InputError(
            f"{text!r} is not a positive number", place="reach", remedy="metres, such as 0.6"
        )
    return found
