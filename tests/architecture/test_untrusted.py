"""Readers of foreign files open nothing themselves: all of it comes through the one door."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# Modules and folders whose paths come from somebody else; more may be added.
READERS = (
    "converters/orusd_hypersim",
    "converters/orusd_openrooms",
    "converters/orusd_scans",
    "openrooms_usd/appearance",
    "openrooms_usd/importing/captures.py",
    "openrooms_usd/description",
    "openrooms_usd/edits",
    "openrooms_usd/hdf5.py",
    "openrooms_usd/imagefile.py",
    "openrooms_usd/ledger.py",
    "openrooms_usd/loading",
    "openrooms_usd/package.py",
    "openrooms_usd/rendering",
    "openrooms_usd/usd",
    "openrooms_usd/validation",
    "openrooms_usd/library/models/gltf.py",
    "openrooms_usd/library/models/meshfile.py",
    "openrooms_usd/library/ownmaterials",
    "openrooms_usd/library/models/usdfile.py",
    "openrooms_usd/library/models/wavefront.py",
    "openrooms_usd/library/styles/assignment/annotations.py",
    "openrooms_usd/scan/models/meshscene.py",
    "openrooms_usd/library/models/cads.py",
    "openrooms_usd/unpickling",
)
# Calls by the last word of what is called, where it may be a method of any object ...
METHODS = {"read_bytes", "read_text", "fromfile", "genfromtxt", "memmap", "mmap"}
# ... and by their whole name. Files that a reader makes itself are written, so not forbidden.
CALLS = {
    "open",
    "io.open",
    "os.open",
    "np.load",
    "zipfile.ZipFile",
    "zipfile.is_zipfile",
    "tarfile.open",
    "gzip.open",
    "laspy.open",
    "pye57.E57",
    "h5py.File",
    "loadmat",
    "whosmat",
    "trimesh.load",
    "trimesh.load_scene",
    "trimesh.load_mesh",
    "OpenImageIO.ImageInput.open",
    "OpenImageIO.ImageBuf",
    "Sdf.Layer.FindOrOpen",
    "Sdf.Layer.OpenAsAnonymous",
    "Usd.Stage.Open",
    "UsdUtils.ComputeAllDependencies",
}
# What is allowed all the same: how often, and why the door has been passed there.
ALLOWED = {
    ("converters/orusd_openrooms/framefiles.py", "h5py.File"): "writes",
    ("converters/orusd_hypersim/hdf5.py", "h5py.File"): "writes",
    ("openrooms_usd/hdf5.py", "h5py.File"): "checked before",
    ("openrooms_usd/description/categories.py", "(_FOLDER / f'{name}.py').read_text"): "our code",
    ("openrooms_usd/loading/shards.py", "tarfile.open"): "reads the stream of the door",
    ("openrooms_usd/importing/captures.py", "target.read_bytes"): "a file, and compared alone",
    ("openrooms_usd/appearance/authoring.py", "Usd.Stage.Open"): "looked through before",
    ("openrooms_usd/edits/foreign.py", "Sdf.Layer.OpenAsAnonymous"): "looked through before",
    ("openrooms_usd/edits/merging.py", "Usd.Stage.Open"): "layers that were looked through",
    ("openrooms_usd/ledger.py", "self._file.open"): "writes",
    ("openrooms_usd/library/ownmaterials/materialx.py", "Usd.Stage.Open"): "a layer in memory",
    ("openrooms_usd/package.py", "Sdf.Layer.FindOrOpen"): "looked through before",
    ("openrooms_usd/package.py", "target.open"): "writes",
    ("openrooms_usd/package.py", "zipfile.ZipFile"): "writes",
    ("openrooms_usd/package.py", "path.read_bytes"): "a copy of its own",
    ("openrooms_usd/rendering/manifest.py", "Path('/proc/cpuinfo').read_text"): "of the system",
    ("openrooms_usd/usd/mapping.py", "TABLE.read_text"): "of the package",
    ("openrooms_usd/usd/files/layers.py", "zipfile.is_zipfile"): "a regular file",
    ("openrooms_usd/usd/files/layers.py", "beside.read_bytes"): "what was just written",
    ("converters/orusd_openrooms/readers.py", "OpenImageIO.ImageInput.open"): "checked before",
    (
        "converters/orusd_scans/formats/depthpicture.py",
        "OpenImageIO.ImageInput.open",
    ): "checked before",
    ("converters/orusd_scans/formats/laser.py", "laspy.open"): "reads the stream of the door",
    ("converters/orusd_scans/formats/laz_reader.py", "laspy.open"): "reads the stream of the door",
    (
        "converters/orusd_scans/formats/laser.py",
        "pye57.E57",
    ): "wants a path; opened and checked before",
    ("converters/orusd_scans/formats/pcd.py", "np.fromfile"): "reads the stream of the door",
    ("converters/orusd_scans/formats/ply.py", "np.fromfile"): "reads the stream of the door",
    ("converters/orusd_scans/formats/ply.py", "np.memmap"): "reads the stream of the door",
    ("converters/orusd_scans/sunrgbd/files.py", "np.fromfile"): "reads the stream of the door",
    ("converters/orusd_scans/sunrgbd/files.py", "loadmat"): "reads the stream of the door",
    ("converters/orusd_scans/sunrgbd/files.py", "whosmat"): "reads the stream of the door",
    ("openrooms_usd/importing/captures.py", "path.open"): "writes the copy",
    ("openrooms_usd/edits/foreign.py", "Sdf.Layer.FindOrOpen"): "looked through before",
    ("openrooms_usd/edits/merging.py", "Sdf.Layer.FindOrOpen"): "looked through with the stage",
    ("openrooms_usd/ledger.py", "source.open"): "what this program has just written",
    ("openrooms_usd/package.py", "UsdUtils.ComputeAllDependencies"): "looked through before",
    ("openrooms_usd/rendering/exr.py", "OpenImageIO.ImageInput.open"): "checked before",
    ("openrooms_usd/rendering/sheet.py", "OpenImageIO.ImageBuf"): "pixels in memory",
    ("openrooms_usd/usd/files/crate_reader.py", "Usd.Stage.Open"): "in a process of its own",
    ("openrooms_usd/usd/files/crate_reader.py", "Sdf.Layer.FindOrOpen"): "in a process of its own",
    ("openrooms_usd/imagefile.py", "OpenImageIO.ImageInput.open"): "what was just written",
    ("openrooms_usd/imagefile.py", "path.open"): "what was just written",
    ("openrooms_usd/usd/files/layers.py", "Usd.Stage.Open"): "looked through before",
    ("openrooms_usd/usd/outside.py", "UsdUtils.ComputeAllDependencies"): "looked through before",
    ("openrooms_usd/usd/files/preflight.py", "Sdf.Layer.FindOrOpen"): "this is what looks through",
    ("openrooms_usd/usd/shading/textures.py", "OpenImageIO.ImageInput.open"): "local_file checks",
    ("openrooms_usd/validation/model.py", "UsdUtils.ComputeAllDependencies"): "opened before",
    (
        "openrooms_usd/library/models/usdfile.py",
        "UsdUtils.ComputeAllDependencies",
    ): "checked before",
    ("openrooms_usd/scan/models/meshscene.py", "trimesh.load_scene"): "reads bytes of the door",
    ("openrooms_usd/unpickling/archives.py", "zipfile.ZipFile"): "reads the stream of the door",
}


def modules() -> Iterator[Path]:
    for name in READERS:
        path = ROOT / name
        assert path.exists(), name
        yield from sorted(path.rglob("*.py")) if path.is_dir() else [path]


def opening(source: str) -> Iterator[tuple[int, str]]:
    """The line and the name of every call that opens a path by itself."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        base, _, last = name.rpartition(".")
        through = base == "untrusted" or (base == "" and last in METHODS)
        # Of a path: `path.open("rb")`, which of an archive is `archive.open(info)`.
        of_path = base and last == "open" and all(isinstance(a, ast.Constant) for a in node.args)
        if name in CALLS or of_path or (last in METHODS and not through):
            yield node.lineno, name


@cache
def opened() -> frozenset[tuple[str, int, str]]:
    """Module, line and name of every such call of the readers."""
    texts = {path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in modules()}
    return frozenset((name, *call) for name, text in texts.items() for call in opening(text))


def test_readers_open_nothing_themselves() -> None:
    wrong = [
        f"{name}:{line}: {call}"
        for name, line, call in sorted(opened())
        if (name, call) not in ALLOWED
    ]
    assert wrong == [], "use openrooms_usd.untrusted, or say in ALLOWED why not"


def test_nothing_is_allowed_that_is_not_there() -> None:
    assert set(ALLOWED) - {(name, call) for name, _, call in opened()} == set()


def test_processes_of_our_own_take_no_modules_of_the_current_folder() -> None:
    """Python looks there first for what ``-m`` and ``-c`` import, unless ``-P`` is said."""
    commands = [
        [ast.unparse(part) for part in node.elts]
        for folder in ("openrooms_usd", "converters")
        for path in (ROOT / folder).rglob("*.py")
        if "sys.executable" in (text := path.read_text(encoding="utf-8"))
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.List)
    ]
    ours = [command for command in commands if "sys.executable" in command]
    assert len(ours) >= 3
    assert {command[1] for command in ours} == {"'-P'"}


@pytest.mark.parametrize(
    "code",
    [
        'path.open("rb")',
        "path.open()",
        "path.read_bytes()",
        'path.read_text("utf-8")',
        'open(path, "rb")',
        "np.load(path)",
        "np.fromfile(path)",
        "zipfile.ZipFile(path)",
        "OpenImageIO.ImageInput.open(str(path))",
        "Usd.Stage.Open(str(path))",
        "pye57.E57(path)",
    ],
)
def test_what_opens_a_path_is_found(code: str) -> None:
    assert list(opening(code))


@pytest.mark.parametrize(
    "code",
    [
        "untrusted.read_text(path)",
        'untrusted.read_bytes(path, "model")',
        "archive.open(info)",
        'untrusted.opened(path, "text")',
        "read_text(path)",
        "stream.read()",
    ],
)
def test_the_door_is_no_offence(code: str) -> None:
    assert not list(opening(code))
