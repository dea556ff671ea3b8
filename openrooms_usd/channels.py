"""The table of ground-truth channels: what every number in a render means.

A renderer declares which of these it can give. Files, manifest, previews and documentation all
read this one table.
"""

from dataclasses import asdict, dataclass
from typing import Final, Literal

Kind = Literal["light", "geometry", "material", "label", "derived"]


@dataclass(frozen=True)
class Channel:
    """One channel of a render.

    Attributes:
        name: The name in files, options and the manifest.
        components: The suffixes in the EXR file (``R`` ...); their number is the channel's depth.
        storage: The sample type in the EXR file.
        unit: What one is; ``1`` for a ratio or a unit vector, ``id`` for a label.
        frame: The frame of positions and directions; empty where there is none.
        kind: Groups channels that are sampled and stored alike; ``derived`` ones no renderer gives.
        meaning: The definition, one sentence.
    """

    name: str
    components: tuple[str, ...]
    storage: Literal["half", "float"]
    unit: str
    frame: str
    kind: Kind
    meaning: str

    def as_dict(self) -> dict[str, object]:
        """The row as plain data."""
        return asdict(self)


_RGB = ("R", "G", "B")
_XYZ = ("X", "Y", "Z")
_ONE = ("Y",)


def _ids(name: str, meaning: str) -> Channel:
    return Channel(name, _ONE, "float", "id", "", "label", meaning)


CHANNELS: Final[dict[str, Channel]] = {
    channel.name: channel
    for channel in (
        Channel(
            "radiance", _RGB, "float", "nit", "", "light",
            "scene-linear radiance, Rec.709 primaries, D65; 0.2126 R + 0.7152 G + 0.0722 B is "
            "luminance in cd/m2; box filter over the pixel",
        ),
        Channel("depth", _ONE, "float", "m", "camera", "geometry",
                "planar depth along the optical axis; 0 where there is no surface"),
        Channel("distance", _ONE, "float", "m", "camera", "geometry",
                "Euclidean distance from the camera; 0 where there is no surface"),
        Channel("position", _XYZ, "float", "m", "world", "geometry",
                "first hit, in steps of 8 mm at 100 km; 0 where there is no surface"),
        Channel("normal", _XYZ, "half", "1", "world", "geometry",
                "unit shading normal with the normal map, on the camera's side; 0 without surface"),
        Channel("normal_geometric", _XYZ, "half", "1", "world", "geometry",
                "unit normal of the triangle, on the camera's side; 0 without surface"),
        Channel("normal_camera", _XYZ, "half", "1", "camera, OpenGL axes", "geometry",
                "the shading normal along right, up, backward; 0 without surface"),
        Channel("base_color", _RGB, "half", "1", "", "material",
                "scene-linear base colour of the first hit"),
        Channel("roughness", _ONE, "half", "1", "", "material",
                "perceptual roughness R of the first hit, alpha = R^2"),
        Channel("metallic", _ONE, "half", "1", "", "material", "metallic of the first hit"),
        Channel("emission_mask", _ONE, "half", "1", "", "material",
                "1 where the first hit emits light, else 0"),
        _ids("semantic", "OpenRooms' 45 classes by number; 0 unlabelled or no surface"),
        _ids("semantic_nyu40", "NYU Depth V2's 40 classes by number; 0 unlabelled or no surface"),
        _ids("instance", "object number, names in the manifest; 0 without surface"),
        _ids("part", "part number, names in the manifest; 0 without surface"),
        _ids("material", "material number, names in the manifest; 0 without surface or material"),
        Channel("valid", _ONE, "half", "1", "", "geometry",
                "1 where the pixel's centre sees a surface, else 0"),
        Channel("friction", _ONE, "half", "1", "", "derived",
                "static Coulomb coefficient of the first hit, dry, by the substance of its "
                "material refined by base_color and roughness (docs/friction.md); a material that "
                "carries only UsdPhysicsMaterialAPI has that value, one that says nothing the mean "
                "of all substances; 0 without surface"),
        Channel("denoised", _RGB, "float", "nit", "", "derived",
                "radiance after denoising, only with --denoise: for people, no measurement"),
    )
}  # fmt: skip

RENDERED: Final = tuple(name for name, row in CHANNELS.items() if row.kind != "derived")
"""The channels that a renderer may give, in the order of the table."""

WRITTEN: Final = (*RENDERED, "friction")
"""The channels that a run writes unless told otherwise, where the renderer gives all of its own."""


def markdown_page() -> str:
    """The table as the documentation page ``docs/channels.md``."""
    head = (
        "# Channels\n\n"
        "What every number in a render means. `orusd channels` prints this table, "
        "`orusd channels --json` gives it to programs, and `manifest.json` repeats it for the "
        "channels of a render. In `channels.exr` a channel's parts are named `<channel>.<part>`.\n"
        "This page is made by `orusd channels --markdown > docs/channels.md`.\n\n"
        "| channel | parts | stored as | unit | frame | meaning |\n"
        "|---|---|---|---|---|---|\n"
    )
    rows = (
        f"| `{row.name}` | {' '.join(row.components)} | {row.storage} | {row.unit} "
        f"| {row.frame or '-'} | {row.meaning} |\n"
        for row in CHANNELS.values()
    )
    return head + "".join(rows)
