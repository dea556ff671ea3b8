"""The words of recipes in one name: ``from ...textures.base import vocabulary as tx``."""
# ruff: noqa: F403

from openrooms_usd.library.textures.base.cells import *
from openrooms_usd.library.textures.base.courses import *
from openrooms_usd.library.textures.base.family import *
from openrooms_usd.library.textures.base.maps import *
from openrooms_usd.library.textures.base.noise import *
from openrooms_usd.library.textures.base.recipe import *
from openrooms_usd.library.textures.base.strewn import *
