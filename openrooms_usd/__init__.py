"""A declarative USD toolkit for photorealistic indoor scenes with ground truth.

``import openrooms_usd as ou`` offers what the command line does, as functions (docs/python.md): a
room is generated, loaded or imported, composed into USD, then rendered, simulated, converted. The
names are loaded on first use, so that importing the package costs nothing: ``pxr``, ``numpy`` and
renderers are imported by the functions that need them.
"""

import sys
from types import ModuleType
from typing import TYPE_CHECKING

from openrooms_usd.lazy import loader
from openrooms_usd.version import __version__ as __version__

if TYPE_CHECKING:
    from openrooms_usd.api import robots as robots
    from openrooms_usd.api.camera import Camera as Camera
    from openrooms_usd.api.datasets import dataset as dataset
    from openrooms_usd.api.datasets import plan_dataset as plan_dataset
    from openrooms_usd.api.datasets import run_dataset as run_dataset
    from openrooms_usd.api.films import render_path as render_path
    from openrooms_usd.api.light import Lightmaps as Lightmaps
    from openrooms_usd.api.light import Probe as Probe
    from openrooms_usd.api.light import Probes as Probes
    from openrooms_usd.api.light import bake as bake
    from openrooms_usd.api.light import probe as probe
    from openrooms_usd.api.light import relight as relight
    from openrooms_usd.api.rendered import Render as Render
    from openrooms_usd.api.rendered import View as View
    from openrooms_usd.api.rendered import read_render as read_render
    from openrooms_usd.api.renderer import OpenRenderer as OpenRenderer
    from openrooms_usd.api.renderer import Picture as Picture
    from openrooms_usd.api.renderer import open_renderer as open_renderer
    from openrooms_usd.api.renders import compare as compare
    from openrooms_usd.api.renders import render as render
    from openrooms_usd.api.rooms import copy_example as copy_example
    from openrooms_usd.api.rooms import generate as generate
    from openrooms_usd.api.rooms import import_capture as import_capture
    from openrooms_usd.api.rooms import load as load
    from openrooms_usd.api.rooms import save as save
    from openrooms_usd.api.scenes import Scene as Scene
    from openrooms_usd.api.scenes import compose as compose
    from openrooms_usd.api.scenes import convert as convert
    from openrooms_usd.api.scenes import open as open
    from openrooms_usd.api.scenes import simulate as simulate
    from openrooms_usd.api.scenes import validate as validate
    from openrooms_usd.description.rendering import RenderSettings as RenderSettings
    from openrooms_usd.description.room import Room as Room
    from openrooms_usd.errors import OrusdError as OrusdError

_HOME = {
    "Camera": "openrooms_usd.api.camera",
    "Lightmaps": "openrooms_usd.api.light",
    "OpenRenderer": "openrooms_usd.api.renderer",
    "OrusdError": "openrooms_usd.errors",
    "Picture": "openrooms_usd.api.renderer",
    "Probe": "openrooms_usd.api.light",
    "Probes": "openrooms_usd.api.light",
    "Render": "openrooms_usd.api.rendered",
    "RenderSettings": "openrooms_usd.description.rendering",
    "Room": "openrooms_usd.description.room",
    "Scene": "openrooms_usd.api.scenes",
    "View": "openrooms_usd.api.rendered",
    "bake": "openrooms_usd.api.light",
    "compare": "openrooms_usd.api.renders",
    "compose": "openrooms_usd.api.scenes",
    "convert": "openrooms_usd.api.scenes",
    "copy_example": "openrooms_usd.api.rooms",
    "dataset": "openrooms_usd.api.datasets",
    "generate": "openrooms_usd.api.rooms",
    "import_capture": "openrooms_usd.api.rooms",
    "load": "openrooms_usd.api.rooms",
    "open": "openrooms_usd.api.scenes",
    "open_renderer": "openrooms_usd.api.renderer",
    "plan_dataset": "openrooms_usd.api.datasets",
    "probe": "openrooms_usd.api.light",
    "read_render": "openrooms_usd.api.rendered",
    "relight": "openrooms_usd.api.light",
    "render": "openrooms_usd.api.renders",
    "render_path": "openrooms_usd.api.films",
    "robots": "openrooms_usd.api",
    "run_dataset": "openrooms_usd.api.datasets",
    "save": "openrooms_usd.api.rooms",
    "simulate": "openrooms_usd.api.scenes",
    "validate": "openrooms_usd.api.scenes",
}

__all__ = [
    "Camera",
    "Lightmaps",
    "OpenRenderer",
    "OrusdError",
    "Picture",
    "Probe",
    "Probes",
    "Render",
    "RenderSettings",
    "Room",
    "Scene",
    "View",
    "__version__",
    "bake",
    "compare",
    "compose",
    "convert",
    "copy_example",
    "dataset",
    "generate",
    "import_capture",
    "load",
    "open",
    "open_renderer",
    "plan_dataset",
    "probe",
    "read_render",
    "relight",
    "render",
    "render_path",
    "robots",
    "run_dataset",
    "save",
    "simulate",
    "validate",
]

if not TYPE_CHECKING:  # To type checkers there is nothing but the names above.
    __getattr__ = loader(__name__, _HOME)


def __dir__() -> list[str]:
    """What people are offered; modules are imported by their own names."""
    return __all__


class _Package(ModuleType):
    """This package: importing its part ``render`` does not hide its function ``render``.

    The import system sets every module as an attribute of its package. Some of ours have the name
    of what they are for, and so have the functions of the front door.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if name not in _HOME or not isinstance(value, ModuleType):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
