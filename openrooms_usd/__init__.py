"""A declarative USD toolkit for photorealistic indoor scenes with ground truth.

``import openrooms_usd as ou`` offers what the command line does, as functions
(docs/howto/python.md): a room is built, generated, loaded or imported, composed into USD, then
edited, rendered, simulated, converted. ``open_`` gives a handle to what lies on disk, ``load_`` a
value in memory, ``import_`` makes ours of what is foreign, ``write_`` and ``save`` make files. The
names are loaded on first use, so that importing the package costs nothing: ``pxr``, ``numpy`` and
renderers are imported by the functions that need them.
"""

from typing import TYPE_CHECKING

from openrooms_usd.lazy import homes, loader
from openrooms_usd.version import __version__ as __version__

if TYPE_CHECKING:
    from openrooms_usd.api import robots as robots
    from openrooms_usd.api.appearing import find_appearance as find_appearance
    from openrooms_usd.api.camera import Camera as Camera
    from openrooms_usd.api.datasets import plan_dataset as plan_dataset
    from openrooms_usd.api.datasets import run_dataset as run_dataset
    from openrooms_usd.api.datasets import write_dataset as write_dataset
    from openrooms_usd.api.films import render_path as render_path
    from openrooms_usd.api.light import Lightmaps as Lightmaps
    from openrooms_usd.api.light import Probe as Probe
    from openrooms_usd.api.light import Probes as Probes
    from openrooms_usd.api.light import bake as bake
    from openrooms_usd.api.light import probe as probe
    from openrooms_usd.api.light import relight as relight
    from openrooms_usd.api.rendered import Render as Render
    from openrooms_usd.api.rendered import View as View
    from openrooms_usd.api.rendered import open_render as open_render
    from openrooms_usd.api.renderer import OpenRenderer as OpenRenderer
    from openrooms_usd.api.renderer import Picture as Picture
    from openrooms_usd.api.renderer import open_renderer as open_renderer
    from openrooms_usd.api.renders import compare as compare
    from openrooms_usd.api.renders import render as render
    from openrooms_usd.api.room import Room as Room
    from openrooms_usd.api.rooms import generate as generate
    from openrooms_usd.api.rooms import import_capture as import_capture
    from openrooms_usd.api.rooms import load_room as load_room
    from openrooms_usd.api.rooms import new_room as new_room
    from openrooms_usd.api.scene import Scene as Scene
    from openrooms_usd.api.scenes import compose as compose
    from openrooms_usd.api.scenes import convert as convert
    from openrooms_usd.api.scenes import open_scene as open_scene
    from openrooms_usd.api.scenes import simulate as simulate
    from openrooms_usd.api.scenes import validate as validate
    from openrooms_usd.demo import copy_example as copy_example
    from openrooms_usd.description.rendering import RenderSettings as RenderSettings
    from openrooms_usd.errors import OrusdError as OrusdError

# What each module offers. Type checkers read the lines above; a test keeps both equal.
_OFFERED = {
    "api": ("robots",),
    "api.appearing": ("find_appearance",),
    "api.camera": ("Camera",),
    "api.datasets": ("plan_dataset", "run_dataset", "write_dataset"),
    "api.films": ("render_path",),
    "api.light": ("Lightmaps", "Probe", "Probes", "bake", "probe", "relight"),
    "api.rendered": ("Render", "View", "open_render"),
    "api.renderer": ("OpenRenderer", "Picture", "open_renderer"),
    "api.renders": ("compare", "render"),
    "api.room": ("Room",),
    "api.rooms": ("generate", "import_capture", "load_room", "new_room"),
    "api.scene": ("Scene",),
    "api.scenes": ("compose", "convert", "open_scene", "simulate", "validate"),
    "description.rendering": ("RenderSettings",),
    "demo": ("copy_example",),
    "errors": ("OrusdError",),
}
_HOME = homes(__name__, _OFFERED)

__all__ = sorted([*_HOME, "__version__"])

if not TYPE_CHECKING:  # To type checkers there is nothing but the names above.
    __getattr__ = loader(__name__, _HOME)


def __dir__() -> list[str]:
    """What people are offered; modules are imported by their own names."""
    return __all__
