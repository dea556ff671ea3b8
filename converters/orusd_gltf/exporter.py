"""What is registered as entry point: an exporter that loads USD when it is used."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from openrooms_usd.exporters import Report
from openrooms_usd.progress import Progress, silent
from orusd_gltf.options import parsed

if TYPE_CHECKING:
    from pxr import Usd


class GltfExporter:
    """Writes a stage as one GLB file."""

    writes = (".glb",)

    def convert(
        self,
        stage: "Usd.Stage",
        destination: Path,
        options: Mapping[str, Any],
        progress: Progress = silent,
    ) -> Report:
        """Write ``stage`` to the file ``destination``.

        Args:
            stage: The composed stage, with any up axis and unit.
            destination: The ``.glb`` file.
            options: Those of `orusd_gltf.options.Options`.
            progress: Called with each surface.

        Returns:
            What became of every prim.

        Raises:
            InputError: An option is not known.
            MissingPackageError: A compression needs a package that is not installed.
            OutputError: The file cannot be written, or would be larger than GLB allows.
        """
        asked = parsed(options)
        from openrooms_usd import atomic, claims
        from orusd_gltf.scene import translate

        claims.check_output(destination)
        data, report = translate(stage, asked, progress)
        with claims.output(destination):
            atomic.write_bytes(destination, data)
        return report
