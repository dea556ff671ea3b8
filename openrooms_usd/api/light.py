"""Light beside pictures: lamps of a render turned, probes of light at a point, lightmaps."""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd.api.given import AnyPath, path_of, points_of, unknown_name, usd_file
from openrooms_usd.api.settings import BAKE, PROBE, settings_of, takes_settings
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from openrooms_usd.description.rendering import RenderSettings
    from openrooms_usd.rendering.relight import Relit

_PROBES: Final = "probes"
_LIGHTMAPS: Final = "baked"

Point = tuple[float, float, float]


def relight(
    view: AnyPath,
    lights: Mapping[str, float] | None = None,
    *,
    kelvin: Mapping[str, float] | None = None,
    out: AnyPath | None = None,
) -> "Relit":
    """Turn the lights of a rendered view, without rendering again.

    Args:
        view: A view that was rendered with the channel ``radiance_i``, or its folder.
        lights: By the light's name, what it is multiplied by; 0 turns it off. Others stay.
        kelvin: By the lamp's name, its new colour temperature at the same luminance.
        out: A folder that receives ``radiance.exr``, ``radiance.png`` and ``manifest.json``; by
            default nothing is written.

    Returns:
        ``.radiance``, (height, width, 3), and ``.factors``, what each light was multiplied by.

    Raises:
        InputError: It is not a view, has no light channels, or a light cannot be changed as asked.
        OutputError: The folder cannot be written, or holds what is not ours.
    """
    from openrooms_usd.rendering import relight as relighting

    wanted = relighting.Relighting(dict(lights or {}), dict(kelvin or {}))
    picture = relighting.relit_view(path_of(view, "a view of a render"), wanted)
    if out is not None:
        relighting.write_relit(path_of(out), picture)
    return picture


@dataclass(frozen=True, eq=False, repr=False)
class Probe:
    """All light that arrives at a point.

    Attributes:
        name: Of its files.
        folder: Where they lie.
        entry: What ``probes.json`` says of it.
    """

    name: str
    folder: Path
    entry: Mapping[str, Any]

    def __repr__(self) -> str:
        return f"Probe({self.name!r} at {self.position})"

    @property
    def position(self) -> Point:
        """World, metres."""
        x, y, z = self.entry["position"]
        return x, y, z

    @property
    def panorama(self) -> "NDArray[np.float32]":
        """(height, width, 3) nits, latitude-longitude; ``probes.json`` says its axes.

        Raises:
            InputError: The file is missing or damaged.
        """
        from openrooms_usd.rendering.exr import read_picture

        return read_picture(self.folder / self.entry["panorama"])

    @property
    def radiance(self) -> "NDArray[np.float64]":
        """(9, 3) spherical harmonics of the radiance, in world axes."""
        return self._numbers("radiance")

    @property
    def irradiance(self) -> "NDArray[np.float64]":
        """(9, 3) spherical harmonics of the irradiance of a surface by its normal, lux."""
        return self._numbers("irradiance")

    @property
    def estimated_error(self) -> float | None:
        """Robust, of the panorama; None where a single path a pixel gives no estimate."""
        error: float | None = self.entry["estimated_robust_error"]
        return error

    def _numbers(self, key: str) -> "NDArray[np.float64]":
        import numpy as np

        return np.array(self.entry[key], dtype=np.float64)


@dataclass(frozen=True, eq=False, repr=False)
class Probes(Mapping[str, Probe], os.PathLike[str]):
    """Light probes by name.

    Attributes:
        folder: Where they lie, with ``probes.json``.
        manifest: What stands there.
    """

    folder: Path
    manifest: Mapping[str, Any]

    def __fspath__(self) -> str:
        return str(self.folder)

    def __getitem__(self, name: str) -> Probe:
        """A probe.

        Raises:
            UnknownNameError: There is none of that name.
        """
        entry = next((row for row in self.manifest["probes"] if row["name"] == name), None)
        if entry is None:
            raise unknown_name("probe", name, self, self.folder)
        return Probe(name, self.folder, entry)

    def __iter__(self) -> Iterator[str]:
        return (str(row["name"]) for row in self.manifest["probes"])

    def __len__(self) -> int:
        return len(self.manifest["probes"])

    def __repr__(self) -> str:
        return f"Probes({str(self.folder)!r}: {', '.join(self)})"


@takes_settings(*PROBE, samples="Paths for each pixel; 64 by default.")
def probe(
    scene: AnyPath,
    out: AnyPath | None = None,
    *,
    at: Sequence[Point] = (),
    openings: bool = False,
    settings: "RenderSettings | None" = None,
    progress: Progress = silent,
    **fields: Any,
) -> Probes:
    """Make light probes in a scene, as real-time engines use them.

    Args:
        scene: A composed room or any USD file.
        out: The folder to write; by default ``probes`` beside the scene.
        at: Positions, world, metres; they are named ``probe_0``, ``probe_1``, …
        openings: Whether there is a probe in the centre of every opening too.
        settings: What is asked for, in one record; its resolution is that of the panoramas,
            256x128 by default.
        progress: Called with what is done and the finished fraction.
        **fields: The same, by name:

    Returns:
        The probes by name: ``.panorama``, ``.radiance`` and ``.irradiance``.

    Raises:
        InputError: There is nothing to do, or a number is absurd.
        OutputError: The folder cannot be written.
        RenderError: The renderer makes no probes.
    """
    from openrooms_usd.rendering.probes import probe_stage
    from openrooms_usd.usd.files.diagnostics import quiet

    file = usd_file(scene)
    folder = file.parent / _PROBES if out is None else path_of(out)
    points, wanted = points_of(at, "at"), settings_of(settings, fields, PROBE)
    with quiet():
        manifest = probe_stage(
            file, folder, wanted, at=points, at_openings=openings, progress=progress
        )
    return Probes(folder, manifest)


@dataclass(frozen=True, eq=False, repr=False)
class Lightmaps(os.PathLike[str]):
    """The light of a stage as textures.

    Attributes:
        folder: Where they lie, with ``lightmaps.json``.
        manifest: What stands there.
    """

    folder: Path
    manifest: Mapping[str, Any]

    def __fspath__(self) -> str:
        return str(self.folder)

    def __repr__(self) -> str:
        return f"Lightmaps({str(self.folder)!r}: {', '.join(self.lights)})"

    @property
    def layer(self) -> Path:
        """The layer that adds them to the stage."""
        return self.folder / str(self.manifest["layer"])

    @property
    def stage(self) -> Path:
        """The stage under that layer."""
        return self.folder / "baked.usda"

    @property
    def lights(self) -> tuple[str, ...]:
        """The names of the lights that have textures, by their numbers."""
        return tuple(str(row["name"]) for row in self.manifest["lights"])

    def irradiance(self, light: str | None = None, *, atlas: int = 0) -> "NDArray[np.float32]":
        """(height, width, 3) lux, top row first.

        Args:
            light: One of `lights`; None: the sum of them.
            atlas: Which picture.

        Raises:
            InputError: The file is missing or damaged.
            UnknownNameError: There is no such light or atlas.
        """
        from openrooms_usd.rendering.exr import read_picture

        rows = self.manifest["atlases"]
        if not 0 <= atlas < len(rows):
            raise unknown_name("atlas", str(atlas), map(str, range(len(rows))), self.folder)
        if light is None:
            return read_picture(self.folder / rows[atlas]["irradiance"])
        if light not in self.lights:
            raise unknown_name("light", light, self.lights, self.folder)
        return read_picture(self.folder / rows[atlas]["lights"][self.lights.index(light)])


@takes_settings(*BAKE, samples="Paths for each texel; 256 by default.")
def bake(
    scene: AnyPath,
    out: AnyPath | None = None,
    *,
    texel: float = 0.05,
    max_texels: int | None = None,
    settings: "RenderSettings | None" = None,
    progress: Progress = silent,
    **fields: Any,
) -> Lightmaps:
    """Write the light of a scene as lightmaps, as real-time engines use them.

    Args:
        scene: A composed room or any USD file; it stays as it is.
        out: The folder to write; by default ``baked`` beside the scene.
        texel: Side of a texel on the surfaces, metres.
        max_texels: Of all atlases together; texels grow until there are no more. 4 million by
            default.
        settings: What is asked for, in one record.
        progress: Called with what is done and the finished fraction.
        **fields: The same, by name:

    Returns:
        The textures as arrays: ``.irradiance()`` and ``.irradiance("window_0")``; ``.layer`` and
        ``.stage`` are files.

    Raises:
        InputError: There is nothing to light, or a number is absurd.
        MissingPackageError: xatlas is not installed.
        OutputError: The folder cannot be written.
        RenderError: The renderer lights no texels.
    """
    from openrooms_usd.rendering.bake.baking import MOST_TEXELS, AtlasLayout, bake_stage
    from openrooms_usd.usd.files.diagnostics import quiet

    file = usd_file(scene)
    folder = file.parent / _LIGHTMAPS if out is None else path_of(out)
    wanted = settings_of(settings, fields, BAKE)
    layout = AtlasLayout(texel, most_texels=MOST_TEXELS if max_texels is None else max_texels)
    with quiet():
        manifest = bake_stage(file, folder, wanted, layout, progress=progress)
    return Lightmaps(folder, manifest)
