"""What is registered as entry points: a renderer and an exporter that load Mitsuba when used."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd.channels import CHANNELS, RENDERED
from openrooms_usd.exporters import Report
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.contract import NO_OPTIONS
from orusd_mitsuba import variants

if TYPE_CHECKING:
    from pxr import Usd

    from openrooms_usd.rendering.scene.arrays import Scene
    from orusd_mitsuba.session import MitsubaSession


class MitsubaRenderer:
    """Renders scenes with Mitsuba 3: on an NVIDIA GPU, on the CPU by LLVM, or plainly."""

    channels: Final = tuple(name for name in RENDERED if CHANNELS[name].kind == "light")

    options: Final[Mapping[str, str]] = {
        "variant": "what computes: auto (the fastest that works here; for very many instances "
        "scalar, which keeps them), cuda, llvm or scalar",
        "bsdf": "how surfaces reflect: auto (as each material says; in scalar, which runs "
        "OpenRooms' model some hundred times slower, preview), openrooms or preview",
    }

    def open(self, scene: "Scene", options: Mapping[str, str] = NO_OPTIONS) -> "MitsubaSession":
        """Build a scene, once.

        Args:
            scene: The translated stage.
            options: See `options`.

        Raises:
            InputError: No reflectance model has that name.
            RenderError: The backend is not available.
            MissingPackageError: Mitsuba is not installed.
        """
        name = options.get("variant", "auto")
        chosen = variants.choose(name)
        # Mitsuba is imported only now: which library it loads is chosen first.
        from orusd_mitsuba.limits import expanded_triangles, kept_advice
        from orusd_mitsuba.session import MitsubaSession

        if name == "auto" and chosen.is_llvm and expanded_triangles(scene):
            chosen = replace(variants.choose("scalar"), advice=kept_advice(scene))
        return MitsubaSession(scene, chosen, options.get("bsdf", "auto"))

    def diagnose(self) -> dict[str, str]:
        """What works on this machine, in words, by backend."""
        return variants.diagnose()


class MitsubaExporter:
    """Writes a stage as a Mitsuba XML scene with its meshes and textures beside it."""

    writes = ("", ".xml")

    def convert(
        self,
        stage: "Usd.Stage",
        destination: Path,
        options: Mapping[str, Any],
        progress: Progress = silent,
    ) -> Report:
        """Write ``stage`` to ``destination``.

        Args:
            stage: The composed stage.
            destination: The ``.xml`` file, or a folder that receives ``scene.xml``.
            options: None is known; each that is given is refused.
            progress: Called with each surface.

        Raises:
            InputError: An option is not known.
            OutputError: The destination cannot be written.
        """
        from orusd_mitsuba.export.exporter import export_scene

        return export_scene(stage, destination, options, progress)
