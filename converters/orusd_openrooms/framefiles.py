"""The files of a view: which channels each is made of, and how."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic
from openrooms_usd.arrays import Bytes, Floats
from openrooms_usd.errors import MissingPackageError, writing
from orusd_openrooms import images
from orusd_openrooms.frame import COARSER, Frame, Pixels, coarser, irradiance, stored, tiled
from orusd_openrooms.images import write_rgbe
from orusd_openrooms.layout import Place
from orusd_openrooms.lightfiles import write_lights


def write_binary(path: Path, pixels: NDArray[Any], kind: Literal["<f4", "<i4"]) -> None:
    """Write pixels row by row, the top row first.

    Args:
        path: The file.
        pixels: (height, width) or (height, width, components).
        kind: The type of a number.

    Raises:
        OutputError: The file cannot be written.
    """
    size = struct.pack("<ii", *pixels.shape[:2])
    atomic.write_bytes(path, size + np.ascontiguousarray(pixels, kind).tobytes())


def write_frame(place: Place, number: int, frame: Frame) -> None:
    """Write all files of a view that its channels give; ``frame.missing`` has the others.

    Args:
        place: Where they go.
        number: Of the frame.
        frame: The view.

    Raises:
        InputError: A file of the render is damaged.
        OutputError: A file cannot be written.
    """
    # Pixels of a render may hold any number, NaN and infinity: numpy must not warn.
    with np.errstate(over="ignore", invalid="ignore"):
        for name, made in _FRAME.items():
            path = place.frame(name, number)
            if path and not frame.misses(name, made.needs):
                made.write(path, frame)
        write_lights(place, number, frame)


def _write_parts(path: Path, frame: Frame) -> None:
    """Model, material and object of every pixel; a render knows no models, so each object is one.

    What emits has the object 0 and a model of its own, as lamps and windows of the release have.
    """
    numbers = {name: frame.view.labels(name) for name in _PARTS}
    there, emits = numbers["instance"] > 0, numbers["emission_mask"] > 0
    model = numbers["instance"] + np.where(emits, frame.instances, 0)
    # Loaders take the material 0 of a model for what surrounds it.
    rows = (model, numbers["material"] + 1, np.where(emits, 0, numbers["instance"]))
    write_binary(path, np.where(there[..., None], np.stack(rows, axis=-1), 0), "<i4")


_PARTS: Final = ("instance", "material", "emission_mask")


def _write_labels(path: Path, frame: Frame) -> None:
    with atomic.replacing(path) as beside:
        np.save(beside, frame.view.labels("semantic").astype(np.int32), allow_pickle=False)


def _write_environment(path: Path, frame: Frame) -> None:
    assert frame.environment is not None
    picture = tiled(frame.environment)
    write_rgbe(path, stored(picture, frame.order))


def _write_direct_environment(path: Path, frame: Frame) -> None:
    grid = frame.view.grid("environment_direct")
    assert grid is not None
    # As many points as a grid of a quarter of the other's rows has, or those that there are.
    factor = max(1, COARSER * grid.shape[0] // frame.grid[0])
    if grid.shape[0] % factor or grid.shape[1] % factor:
        frame.missing["imenvDirect"] = (
            f"its grid of {grid.shape[1]}x{grid.shape[0]} is not a multiple"
        )
        return
    picture = tiled(coarser(grid, factor))
    write_rgbe(path, stored(picture, frame.order))


def _write_shading(path: Path, frame: Frame) -> None:
    if frame.environment is not None:
        write_rgbe(path, irradiance(frame.environment))
    else:
        write_rgbe(path, frame.coarse(frame.view.pixels["irradiance"]))


def _write_fit(path: Path, frame: Frame) -> None:
    lobes = frame.view.fit("environment_sg")
    assert lobes is not None
    try:
        write_fit(path, lobes)
    except MissingPackageError as error:
        frame.missing["imsgEnv"] = f"{error.message}: {error.remedy}"


class _Made(NamedTuple):
    """What a file is made of, and how. A need ``a|b`` is met by either."""

    needs: tuple[str, ...]
    write: Callable[[Path, Frame], None]


def _picture(channel: str, code: Callable[[Pixels], Bytes]) -> _Made:
    return _Made(
        (channel,), lambda path, frame: images.write_picture(path, code(frame.view.pixels[channel]))
    )


_FRAME: Final[dict[str, _Made]] = {
    "im": _Made(("radiance",), lambda path, f: write_rgbe(path, f.view.pixels["radiance"])),
    "imbaseColor": _picture("base_color", images.base_color),
    "imroughness": _picture("roughness", images.ratio),
    "immetallic": _picture("metallic", images.ratio),
    "imnormal": _picture("normal_camera", images.direction),
    "imdepth": _Made(
        ("depth",), lambda path, f: write_binary(path, f.view.pixels["depth"][..., 0], "<f4")
    ),
    "immask": _Made(
        ("valid", "emission_mask"),
        lambda path, f: images.write_picture(
            path, images.light_mask(f.view.pixels["valid"], f.view.pixels["emission_mask"])
        ),
    ),
    "imfriction": _Made(
        ("friction",), lambda path, f: write_binary(path, f.view.pixels["friction"][..., 0], "<f4")
    ),
    "imsemLabel": _Made(("semantic",), _write_labels),
    "imcadmatobj": _Made(_PARTS, _write_parts),
    "imenv": _Made(("environment",), _write_environment),
    "imsgEnv": _Made(("environment_sg",), _write_fit),
    "imshading": _Made(("environment|irradiance",), _write_shading),
    "imenvDirect": _Made(("environment_direct",), _write_direct_environment),
    "imshadingDirect": _Made(
        ("irradiance_direct",),
        lambda path, f: write_rgbe(path, f.coarse(f.view.pixels["irradiance_direct"])),
    ),
}


def write_fit(path: Path, lobes: Floats) -> None:
    """Write the data set ``data``, compressed by lzf.

    Args:
        path: The file.
        lobes: (rows, columns, lobes, 6): theta, phi, sharpness, red, green, blue; the light in the
            direction d is the sum of color exp(sharpness (axis . d - 1)).

    Raises:
        MissingPackageError: h5py is not installed.
        OutputError: The file cannot be written.
    """
    h5py = load_h5py()
    with (
        atomic.replacing(path) as beside,
        writing(path),
        h5py.File(beside, "w", libver="v108") as file,
    ):
        # Without times the same lobes give the same bytes.
        file.create_dataset(
            "data", data=np.ascontiguousarray(lobes, "<f4"), compression="lzf", track_times=False
        )


def load_h5py() -> Any:
    """The package h5py.

    Raises:
        MissingPackageError: It is not installed.
    """
    try:
        import h5py
    except ImportError as error:
        raise MissingPackageError(
            "spherical Gaussians are stored as HDF5, which needs the package 'h5py'",
            remedy="pip install 'openrooms-usd[openrooms]'",
        ) from error
    return h5py
