"""What those who open a USDZ file can do with, as a table."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Profile:
    """What a file holds.

    Attributes:
        purpose: Who it is for, in words.
        without: Types of prims that are left out while all else stays as it is, layer by layer.
        types: The only types of prims that there are, in one plain layer; None for all.
        up: The axis that points up; None as it is.
        pictures: The endings that textures may have.
    """

    purpose: str
    without: frozenset[str] = frozenset()
    types: frozenset[str] | None = None
    up: str | None = None
    pictures: tuple[str, ...] = (".png", ".jpg", ".jpeg", ".exr", ".avif")

    @property
    def is_plain(self) -> bool:
        """Whether it is one layer, without what only USD's own composition can read."""
        return self.types is not None


# In Apple's rules (usdchecker --arkit) core types but instancers, curves, patches and lights.
_ARKIT_NAMES: Final = """
    Scope Xform Camera Shader Material GeomSubset Mesh Sphere Cube Cylinder Cone Capsule Points
"""
_ARKIT_TYPES: Final = frozenset(("", *_ARKIT_NAMES.split()))

DEFAULT: Final = "default"
PROFILES: Final[dict[str, Profile]] = {
    DEFAULT: Profile("every USD program: the scene's folder as it is"),
    "exchange": Profile(
        "programs that show a portal as a lamp, such as Blender", without=frozenset({"PortalLight"})
    ),
    "arkit": Profile(
        "phones: AR Quick Look and RealityKit",
        types=_ARKIT_TYPES,
        up="Y",
        pictures=(".png", ".jpg", ".jpeg"),
    ),
}
