"""What is true of a room's light: pictures of many samples, kept on disk and so made once.

Each is a pair of independent halves, so that their own noise is known and can be taken out of what
is measured against them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.digest import light_digest

Images = dict[str, NDArray[np.float32]]
"""By the name of the channel."""
_KEY_DIGITS: Final = 24


@dataclass(frozen=True)
class References:
    """References of rooms in a folder.

    Attributes:
        folder: Where they are kept.
    """

    folder: Path

    def pair(
        self, scene: Scene, what: Mapping[str, Any], make: Callable[[int], Mapping[str, Any]]
    ) -> tuple[Images, Images]:
        """Two independent halves of a reference.

        Args:
            scene: What is seen; a reference of a scene that has changed is made anew.
            what: What is asked for, by name.
            make: Given 0 or 1, gives the pictures of that half by channel.
        """
        return self._half(scene, what, make, 0), self._half(scene, what, make, 1)

    def _half(
        self,
        scene: Scene,
        what: Mapping[str, Any],
        make: Callable[[int], Mapping[str, Any]],
        half: int,
    ) -> Images:
        path = self.folder / f"{light_digest(scene, {**what, 'half': half})[:_KEY_DIGITS]}.npz"
        if not path.is_file():
            self.folder.mkdir(parents=True, exist_ok=True)
            np.savez(path, **make(half))
        with np.load(path, allow_pickle=False) as found:
            return {name: found[name] for name in found.files}
