"""The physics engines that tests run."""

from importlib.util import find_spec

import pytest

NO_PYBULLET = "PyBullet has no wheel for this Python"
needs_pybullet = pytest.mark.skipif(find_spec("pybullet") is None, reason=NO_PYBULLET)
ENGINES = (pytest.param("pybullet", marks=needs_pybullet), "mujoco")
