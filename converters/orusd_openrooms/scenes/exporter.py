"""A composed room as a scene of OpenRooms, with its meshes, materials, lights and cameras."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from openrooms_usd.errors import InputError
from openrooms_usd.exporters import Report
from openrooms_usd.untrusted import is_plain_name

if TYPE_CHECKING:
    from pxr import Usd


class OpenRoomsXmlExporter:
    """Writes the folders of the release: scenes, layoutMesh, uv_mapped and the others."""

    writes = ("",)

    def convert(self, stage: "Usd.Stage", destination: Path, options: Mapping[str, Any]) -> Report:
        """Write ``stage`` below the folder ``destination``.

        Args:
            stage: A composed room.
            destination: The dataset's folder; further scenes may go into the same.
            options: ``scene``, its name (``scene0000_00``).

        Returns:
            What became of every prim.

        Raises:
            InputError: An option is not known, or the scene's name is not valid.
            StageError: The stage has no room.
            OutputError: A file cannot be written.
        """
        unknown = sorted(set(options) - {"scene"})
        if unknown:
            raise InputError(
                f"the OpenRooms exporter has no option {', '.join(unknown)}", remedy="it has scene"
            )
        name = str(options.get("scene", "scene0000_00"))
        if not is_plain_name(name) or any(word in name for word in (" ", "main_", "hdr", "mask")):
            raise InputError(
                f"{name!r} cannot be the name of a scene", remedy="use one such as scene0001_00"
            )
        from orusd_openrooms.scenes.export import export_scene

        return export_scene(stage, destination, name)
