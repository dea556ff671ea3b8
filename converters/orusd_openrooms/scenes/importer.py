"""OpenRooms' scenes become captures: their layout, objects, materials, lights and cameras."""

from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import capture
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import inverse, nearest_rotation, pose
from openrooms_usd.unpickling import read_pickled
from orusd_openrooms.readers import read_cameras
from orusd_openrooms.scenes import materials
from orusd_openrooms.scenes.records import Bsdf, Color, SceneFile, Step, whole
from orusd_openrooms.scenes.scene import MARK, PlacedShape, Scene, load_scene

# A scene of the release has about twenty.
_MOST_CAMERAS: Final = 10_000
_USUAL_FOV: Final = 57.95
# Three decimals in the files; beyond this something else is wrong.
_CROOKED: Final = 0.02
_SAME: Final = 1e-3
_FARTHEST: Final = 1e6
_KINDS: Final = ("s", "rot", "t")
_FOLDER: Final = "dataset"
_LAYOUT: Final = "layout.obj"
_CAMERAS: Final = "cam.txt"
_TRANSFORMS: Final = "transform.dat"
_ENVIRONMENT: Final = "environment"
_MATERIALS: Final = "materials"
_SHELL: Final = {"floor": "floor", "walls": "wall", "ceiling": "ceiling"}
# Loaders take an environment below this factor as switched off; the files have 1e-8.
_OFF: Final = 1e-3


class OpenRoomsXmlImporter:
    """Reads a scene of the OpenRooms release, its ``main.xml``."""

    options: Mapping[str, str] = {
        "root": "The dataset's folder: uv_mapped, layoutMesh, BRDFOriginDataset and EnvDataset "
        "in it (default: looked for above the scene).",
        "models": "The folder of models, uv_mapped, where it is elsewhere.",
        "layouts": "The folder of layouts, layoutMesh, where it is elsewhere.",
        "materials": "The folder of materials, BRDFOriginDataset, where it is elsewhere.",
        "environments": "The folder of panoramas, EnvDataset, where it is elsewhere.",
        "layout": "The layout's mesh itself, in place of the one that the scene names.",
        "cameras": "The file of cameras (default: cam.txt beside the scene, if there is one).",
    }
    paths = frozenset(options)

    def read(
        self, source: Path, options: Mapping[str, str] = capture.NO_OPTIONS
    ) -> capture.Capture:
        """Read a scene and what it names.

        Args:
            source: ``main.xml``, or one of its variants.
            options: See `options`.

        Raises:
            InputError: The scene or a file that it names is broken or hostile.
        """
        scene = load_scene(source, options)
        frames = read_frames(_cameras(source, options), scene.file, scene.scene_from_world)
        steps = scene.layout.steps if scene.layout else None
        notes = [*scene.notes, *read_transforms(source.parent / _TRANSFORMS, steps)]
        models = tuple(_model(scene, one) for one in scene.placed)
        notes += _missing(scene)
        shell, shell_notes = ({}, []) if scene.imported else _shell_looks(scene)
        environment, sky_notes = ({}, []) if scene.imported else _environment(scene)
        return capture.Capture(
            source=source.name,
            source_from_world=scene.scene_from_world,
            floor=scene.shell.floor,
            height=scene.shell.height,
            openings=tuple(_openings(scene)),
            models=models,
            frames=frames,
            fov=None if frames else scene.file.fov,
            environment=environment,
            shell=shell,
            notes=tuple(dict.fromkeys([*notes, *shell_notes, *sky_notes])),
        )

    def pack(self, source: Path, options: Mapping[str, str] = capture.NO_OPTIONS) -> capture.Packed:
        """The scene, its models with their materials, its layout, its cameras, its panorama."""
        scene = load_scene(source, options)
        contents: dict[str, bytes | Path] = {source.name: source}
        asked = {"root": _FOLDER}
        for model, cad in scene.cads.items():
            for name, content in cad.files(scene.roots.find):
                contents[f"{_FOLDER}/uv_mapped/{model}/{name}"] = content
        contents[f"{_FOLDER}/{MARK}"] = _MARKED
        if scene.layout_file is not None:
            contents[_LAYOUT], asked["layout"] = scene.layout_file, _LAYOUT
        cameras = _cameras(source, options)
        if cameras is not None:
            contents[_CAMERAS], asked["cameras"] = cameras, _CAMERAS
        if (source.parent / _TRANSFORMS).is_file():
            contents[_TRANSFORMS] = source.parent / _TRANSFORMS
        panorama = scene.environment_file
        if panorama is not None and scene.file.environment_scale >= _OFF:
            contents[f"{_ENVIRONMENT}{panorama.suffix.lower()}"] = panorama
        for part, bsdf in _shell_bsdfs(scene).items():
            found = materials.pictures_of(bsdf, scene.roots.find) or {}
            for name, content in materials.tiled_pictures(bsdf, found).items():
                contents[f"{_MATERIALS}/{part}/{name}"] = content
        return capture.Packed(source.name, contents, asked)


_MARKED: Final = (
    b"Models of the dataset with the materials of one scene, as orusd import wrote them.\n"
)


def _cameras(source: Path, options: Mapping[str, str]) -> Path | None:
    if "cameras" in options:
        return Path(options["cameras"])
    beside = source.parent / _CAMERAS
    return beside if beside.is_file() else None


def _model(scene: Scene, one: PlacedShape) -> capture.CapturedModel:
    low, high = one.extent
    return capture.CapturedModel(
        id=one.item.id,
        label=one.item.label,
        file=one.file,
        world_from_model=one.pose.measured,
        half=0.5 * (high - low),
        center=0.5 * (low + high),
        up=one.up,
        front="+Y",
        shifts=one.pose.fixes,
        radiance=_emitted(one),
        looks=one.looks,
    )


def _emitted(one: PlacedShape) -> Color | None:
    """What it emits; lamps of ours that stand for those that do not emit are off, too."""
    stands_in = one.file is None and one.item.kind == "lamp"
    return (0.0, 0.0, 0.0) if stands_in and not one.item.radiance else one.item.radiance


def _openings(scene: Scene) -> Iterator[capture.CapturedOpening]:
    for number, (hole, kind) in enumerate(scene.openings):
        yield capture.CapturedOpening(
            f"hole{number}", kind, hole.center, hole.direction, hole.width, hole.height
        )


def _shell_bsdfs(scene: Scene) -> dict[str, Bsdf]:
    refs = scene.layout.refs if scene.layout is not None else ()
    found = {
        part: next((ref for ref in refs if ref.endswith(f"_{suffix}")), None)
        for part, suffix in _SHELL.items()
    }
    return {part: scene.file.bsdfs[ref] for part, ref in found.items() if ref is not None}


def _shell_looks(scene: Scene) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """What floor, walls and ceiling look like, and what stands for what is not there."""
    looks: dict[str, dict[str, Any]] = {}
    notes = []
    for part, bsdf in _shell_bsdfs(scene).items():
        if "albedo" not in bsdf.maps:
            looks[part] = materials.constant(bsdf)
        elif materials.pictures_of(bsdf, scene.roots.find) is not None:
            size = materials.repeat_m(bsdf, scene.shell.repeats)
            looks[part] = {"file": f"{_MATERIALS}/{part}", "size": size}
        else:
            looks[part] = materials.stand_in(bsdf)
            notes.append(f"{part}: {_stood_for(bsdf, looks[part])}")
    return looks, notes


def _missing(scene: Scene) -> Iterator[str]:
    """What stands for models and their materials that are not there."""
    lacking = Counter("/".join(p.item.model.parts) for p in scene.placed if p.file is None)
    labels = {"/".join(p.item.model.parts): p.item.label for p in scene.placed}
    for model, count in sorted(lacking.items()):
        times = f", {count} times" if count > 1 else ""
        yield f"the model {model} is missing{times}: the library's {labels[model]} replaces it"
    for model, kind, count in scene.filled:
        times = f", {count} times" if count > 1 else ""
        yield f"the model {model} is missing{times}: the library's {kind} fills its opening"
    for model, cad in scene.cads.items():
        looks = cad.looks(scene.roots.find)
        for part, bsdf in cad.wears.items():
            if bsdf is not None and part in looks:
                yield f"{model}, {part}: {_stood_for(bsdf, looks[part])}"


def _stood_for(bsdf: Bsdf, look: Mapping[str, Any]) -> str:
    from orusd_openrooms.scenes.standins import material_name

    name = material_name(bsdf.maps["albedo"])
    return (
        f"the material {name} is missing: {look['substance']} of the library replaces it, without "
        "its factors of albedo and roughness"
    )


def _environment(scene: Scene) -> tuple[dict[str, Any], list[str]]:
    """The world outside, as the description says it."""
    scale, file = scene.file.environment_scale, scene.environment_file
    if scene.file.environment is None or scale < _OFF:
        return {"from": "constant", "illuminance": 0}, []
    if file is None:
        lux = round(float(np.pi) * scale, 3)
        note = (
            f"the panorama {scene.file.environment.rsplit('/', 1)[-1]} is missing: an even sky of "
            f"{scale:g} nits replaces it"
        )
        return {"from": "constant", "illuminance": lux}, [note]
    centre = inverse(scene.scene_from_world)[:3, :3] @ np.array([0.0, 0.0, 1.0])
    turn = float(np.degrees(np.arctan2(centre[0], -centre[1])))
    name = f"{_ENVIRONMENT}{file.suffix.lower()}"
    return {"file": name, "scale": scale, "rotate": round(turn, 6) + 0.0}, []


def read_frames(
    path: Path | None, file: SceneFile, scene_from_world: Array
) -> tuple[capture.CapturedFrame, ...]:
    """The cameras of a scene, counted from 1 as its pictures are.

    Args:
        path: ``cam.txt``; None where there is none.
        file: The scene: its field of view and the size of its pictures.
        scene_from_world: (4, 4) rigid.

    Raises:
        InputError: It is not a list of cameras.
    """
    if path is None:
        return ()
    width, height = file.resolution
    focal = 0.5 * width / np.tan(np.radians(file.fov or _USUAL_FOV) / 2.0)
    K = np.array([[focal, 0.0, 0.5 * width], [0.0, focal, 0.5 * height], [0.0, 0.0, 1.0]])
    world_from_scene = inverse(scene_from_world)
    cameras = read_cameras(path)
    if len(cameras) > _MOST_CAMERAS:
        raise InputError(
            f"{len(cameras):,} cameras; at most {_MOST_CAMERAS:,} are read", place=path
        )
    return tuple(
        capture.CapturedFrame(
            f"{number}",
            world_from_scene @ camera_pose(rows, f"{path}: camera {number}"),
            K,
            file.resolution,
            f"im_{number}.hdr",
        )
        for number, rows in enumerate(cameras, 1)
    )


def camera_pose(rows: Array, place: str) -> Array:
    """(4, 4) from the OpenCV camera frame to the scene.

    Args:
        rows: (3, 3) origin, target, up.
        place: For messages.

    Raises:
        InputError: The rows are not a camera.
    """
    origin, target, up = rows
    view = target - origin
    length, tall = np.linalg.norm(view), np.linalg.norm(up)
    if min(length, tall) < _SAME or abs(view @ up) > _CROOKED * length * tall:
        raise InputError("its view and its up are not at right angles", place=place)
    right = np.cross(view, up)
    frame = np.stack([right / np.linalg.norm(right), -up / tall, view / length], axis=1)
    return pose(nearest_rotation(frame), origin)


def read_transforms(path: Path, layout: tuple[Step, ...] | None) -> Iterator[str]:
    """What ``transform.dat`` says otherwise than the scene: the layout's way from the scan.

    The scene file has the same steps; the pickle is only compared with it.

    Args:
        path: The file, which need not exist.
        layout: The steps of the layout's shape.

    Raises:
        InputError: It is not a pickle of plain data, or holds no transforms.
    """
    if not path.is_file() or layout is None:
        return
    found = read_pickled(path)
    try:
        matrix = np.eye(4)
        for kind, value in found[0]:
            matrix = _step(kind, value) @ matrix
    except (TypeError, ValueError, IndexError, KeyError) as error:
        raise InputError(f"no transforms of a scene: {error}", place=path) from error
    off = float(np.abs(matrix - whole(layout)).max())
    if off > _SAME:
        yield f"{path.name} moves the layout by {off:.3g} m otherwise than the scene, which counts"


def _step(kind: Any, value: Any) -> Array:
    if kind not in _KINDS:
        raise ValueError(f"a step {str(kind)[:20]!r}")
    numbers = np.asarray(value, dtype=np.float64)
    if not (np.abs(numbers) < _FARTHEST).all():
        raise ValueError("a number is not finite")
    if kind == "s":
        return np.diag([*numbers.reshape(3), 1.0])
    return pose(numbers.reshape(3, 3)) if kind == "rot" else pose(np.eye(3), numbers.reshape(3))
