"""The folder of a scene: its cameras, their matrix, and which view of the render each is."""

import os
from pathlib import Path

from openrooms_usd import ledger
from openrooms_usd.errors import InputError
from openrooms_usd.render.manifest import write_json
from openrooms_usd.render.reading import RenderedScene
from orusd_openrooms import cameras, readers
from orusd_openrooms.layout import SHARED_INTRINSICS, Place
from orusd_openrooms.pickles import write_pickled


def write_scene_folder(
    place: Place, root: Path, render: RenderedScene, first: int, known: ledger.Ledger
) -> None:
    """Write the cameras of a scene: the new ones in the place of their numbers, others stay.

    Args:
        place: Where they go.
        root: The dataset's folder, with what was written earlier.
        render: The views.
        first: The number of the first of them.
        known: What earlier runs wrote.

    Raises:
        InputError: Earlier cameras are damaged, or there are too few.
        OutputError: A file cannot be written.
    """
    folder = place.scene_folder
    earlier = root / folder.relative_to(place.root)
    there, told = earlier / "cam.txt", earlier / "views.json"
    poses = readers.read_cameras(there) if os.path.lexists(there) else []
    names = readers.read_view_names(told) if os.path.lexists(told) else []
    # Frames count from 1, or from 0 as in sets that others rendered again.
    start = max(0, first - 1)
    if len(poses) < start:
        raise InputError(
            f"the scene has {len(poses)} cameras, so the next view is number {len(poses) + 1}",
            place=there,
            remedy=f"give --first {len(poses) + 1}, or write the earlier views first",
        )
    end = start + len(render.views)
    new = [cameras.pose(view.world_from_camera) for view in render.views.values()]
    cameras.write_cameras(folder / "cam.txt", [*poses[:start], *new, *poses[end:]])
    names = [*names, *[""] * (len(poses) - len(names))]
    write_json(folder / "views.json", {"views": [*names[:start], *render.views, *names[end:]]})
    write_pickled(folder / "transform.dat", cameras.layout_transforms())
    K = next(iter(render.views.values())).K
    cameras.write_intrinsics(folder / "intrinsic.txt", K)
    shared = root / SHARED_INTRINSICS
    if not os.path.lexists(shared) or known.is_own(shared):
        cameras.write_intrinsics(place.root / SHARED_INTRINSICS, K)
    if place.layout == "merged":
        cameras.write_intrinsics(place.root / place.split / place.scene / "intrinsic.txt", K)
