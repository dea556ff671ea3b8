"""Every USD file below a folder of others becomes a scene or one clear error, in bounded time."""

import os
import sys
from collections import Counter
from multiprocessing import connection, get_context
from pathlib import Path

import pytest

FOLDERS = [Path(one) for one in os.environ.get("ORUSD_USD_SAMPLES", "").split(os.pathsep) if one]
SECONDS = float(os.environ.get("ORUSD_USD_SECONDS", "120"))
ENDINGS = (".usd", ".usda", ".usdc", ".usdz")
PRELOADED = ["openrooms_usd.rendering.opening", "openrooms_usd.usd.moments", "scipy.spatial"]


def translated(path: Path) -> str:
    """What becomes of a file: "scene" or "refused", and what there is to say of it."""
    import numpy as np

    from openrooms_usd.errors import OrusdError
    from openrooms_usd.rendering.scene.translate import translate
    from openrooms_usd.usd.cameras import framing_camera, list_cameras, read_camera
    from openrooms_usd.usd.files.diagnostics import quiet, reading
    from openrooms_usd.usd.files.layers import open_stage
    from openrooms_usd.usd.moments import freeze_time

    try:
        with quiet():
            stage = open_stage(path)
            with reading(path):
                freeze_time(stage)
                scene = translate(stage)
            cameras = list_cameras(stage)
            for camera in cameras:
                read_camera(camera, 8, 6)
            count = len(scene.triangles)
            if count and not cameras:
                framing_camera(stage, 8, 6)
        assert np.isfinite(scene.triangles.corners).all()
    except OrusdError as error:
        return f"refused {error}"
    return f"scene {count} triangles"


def _answer(path: Path, link: connection.Connection) -> None:
    try:
        link.send(translated(path))
    except BaseException as error:
        import traceback

        where = traceback.extract_tb(error.__traceback__)[-1]
        link.send(f"traceback {type(error).__name__}: {error} at {where.filename}:{where.lineno}")


def outcome(path: Path, seconds: float = SECONDS) -> str:
    """The same from a process of its own, or how that ended."""
    context = get_context("forkserver")
    context.set_forkserver_preload(PRELOADED)
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(path, there), daemon=True)
    process.start()
    there.close()
    try:
        return here.recv() if here.poll(seconds) else f"hang more than {seconds:g} s"
    except EOFError:
        process.join()
        return f"crash the process ended with {process.exitcode}"
    finally:
        process.kill()
        process.join()
        process.close()


@pytest.mark.long
@pytest.mark.skipif(not FOLDERS, reason="ORUSD_USD_SAMPLES names no folders of USD files")
def test_files_of_others_are_scenes_or_clear_errors() -> None:
    files = sorted(
        path for folder in FOLDERS for path in folder.rglob("*") if path.suffix in ENDINGS
    )
    found = {path: outcome(path) for path in files}
    print(Counter(said.split()[0] for said in found.values()), file=sys.stderr)
    bad = {str(p): said for p, said in found.items() if not said.startswith(("scene", "refused"))}
    assert files and not bad, "\n".join(f"{path}: {said}" for path, said in bad.items())
