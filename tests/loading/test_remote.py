"""Datasets behind a URL and in a bucket: the same arrays, a small cache, and what goes wrong."""

import functools
import hashlib
import http.server
import os
import random
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd import unfinished
from openrooms_usd.errors import InputError
from openrooms_usd.loading.files import RemoteFiles
from openrooms_usd.loading.opening import open_source
from tests.loading.conftest import render

fsspec = pytest.importorskip("fsspec")

CHANNELS = ("radiance", "depth", "instance")


class Server(http.server.ThreadingHTTPServer):
    """Serves a folder, and counts what it is asked for; some answers may break off."""

    def __init__(self, folder: Path) -> None:
        self.asked: list[str] = []
        self.breaks = 0
        super().__init__(("127.0.0.1", 0), functools.partial(Handler, directory=str(folder)))

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}"


class Handler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *words: object) -> None:
        pass

    def do_GET(self) -> None:
        assert isinstance(self.server, Server)
        self.server.asked.append(self.path)
        if self.path.endswith(".exr") and self.server.breaks:
            self.server.breaks -= 1
            self.break_off()
        else:
            super().do_GET()

    def break_off(self) -> None:
        """Promise a whole file, and send half of it."""
        data = Path(self.translate_path(self.path)).read_bytes()
        self.send_response(200)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data[: len(data) // 2])
        self.close_connection = True


@contextmanager
def serving(folder: Path) -> Iterator[Server]:
    with Server(folder) as found:
        thread = threading.Thread(target=found.serve_forever)
        thread.start()
        try:
            yield found
        finally:
            found.shutdown()
            thread.join()


@pytest.fixture
def server(dataset: Path) -> Iterator[Server]:
    pytest.importorskip("aiohttp")
    with serving(dataset) as found:
        yield found


def test_http_gives_the_same_views_and_fetches_each_once(
    server: Server, dataset: Path, tmp_path: Path
) -> None:
    here, there = open_source(dataset), open_source(server.url, cache=tmp_path)
    assert len(there) == len(here)
    for index in (0, 5, 0):
        a, b = here.read(index, CHANNELS), there.read(index, CHANNELS)
        assert a.name == b.name and a.about == b.about
        np.testing.assert_array_equal(a.world_from_camera, b.world_from_camera)
        for name in CHANNELS:
            np.testing.assert_array_equal(a.images[name], b.images[name])
    views = [path for path in server.asked if path.endswith(".exr")]
    # Neither twice, nor what nobody needs: pictures and plain copies.
    assert len(views) == len(set(views)) == 2
    assert all(path.endswith("/channels.exr") for path in views)
    assert not any(path.endswith(".png") for path in server.asked)


def test_of_compact_renders_only_what_is_needed_is_fetched(
    composed_demo: Path, tmp_path: Path
) -> None:
    """What is left out is worked out again, of fewer files."""
    pytest.importorskip("aiohttp")
    names = ("radiance", "depth", "distance", "position", "instance")
    complete, compact = (
        open_source(
            render(
                composed_demo,
                tmp_path / how,
                (48, 36),
                ",".join(names),
                "--renderer",
                "preview",
                "--camera",
                "view_0",
                "--storage",
                how,
            )
        )
        for how in ("complete", "compact")
    )
    a, b = complete.read(0, names), compact.read(0, names)
    np.testing.assert_array_equal(a.images["depth"], b.images["depth"])
    np.testing.assert_array_equal(a.images["instance"], b.images["instance"])
    np.testing.assert_allclose(a.images["position"], b.images["position"], atol=2e-5)
    np.testing.assert_allclose(a.images["distance"], b.images["distance"], rtol=1e-5)
    off = np.abs(a.images["radiance"] - b.images["radiance"])
    assert 0.0 < off.max() < 0.05 * a.images["radiance"].max()
    with serving(tmp_path / "compact") as server:
        there = open_source(server.url, cache=tmp_path / "cache")
        found = there.read(0, ("position", "instance"))
        np.testing.assert_array_equal(found.images["position"], b.images["position"])
        asked = {path for path in server.asked if path.endswith(".exr")}
        assert asked == {"/view_0/channels.exr"}
        there.read(0, ("radiance",))
        assert {path for path in server.asked if path.endswith(".exr")} - asked == {
            "/view_0/light.exr"
        }


@pytest.mark.slow
def test_of_lights_only_what_is_needed_is_fetched(composed_demo: Path, tmp_path: Path) -> None:
    """Masks lie in another file than light."""
    pytest.importorskip("aiohttp")
    names = ("direct_i", "mask_i")
    words = ("--camera", "view_0", "--storage", "compact")
    render(composed_demo, tmp_path / "there", (16, 12), ",".join(names), *words)
    here = open_source(tmp_path / "there").read(0, names)
    assert len(here.light_numbers) > 1
    with serving(tmp_path / "there") as server:
        there = open_source(server.url, cache=tmp_path / "cache")
        for name, file in (("mask_i", "masks"), ("direct_i", "lights")):
            server.asked.clear()
            found = there.read(0, (name,))
            np.testing.assert_array_equal(found.lights[name], here.lights[name])
            assert found.light_numbers == here.light_numbers
            asked = {path for path in server.asked if path.endswith(".exr")}
            assert asked == {f"/view_0/{file}.exr"}


def test_what_breaks_off_is_asked_for_again(server: Server, dataset: Path, tmp_path: Path) -> None:
    expected = open_source(dataset).read(0, CHANNELS)
    there = open_source(server.url, cache=tmp_path)
    server.breaks = 99
    with pytest.raises(InputError, match=r"channels\.exr: cannot read it"):
        there.read(0, CHANNELS)
    assert len([path for path in server.asked if path.endswith(".exr")]) == 3
    assert [path.name for path in tmp_path.iterdir()] == ["locks"]
    server.breaks = 1
    found = there.read(0, CHANNELS)
    np.testing.assert_array_equal(found.images["radiance"], expected.images["radiance"])


def test_the_cache_leaves_alone_what_another_process_fetches(tmp_path: Path) -> None:
    memory = fsspec.filesystem("memory")
    sums = {}
    for name in ("a.exr", "b.exr"):
        memory.pipe_file(f"/fetched/{name}", name.encode() * 1000)
        sums[name] = hashlib.sha256(name.encode() * 1000).hexdigest()
    files = RemoteFiles("memory://fetched", tmp_path, most=0)
    begun, given_up = (unfinished.beside(tmp_path / name) for name in ("0" * 64, "1" * 64))
    for folder, days in ((begun, 0), (given_up, 2)):
        folder.mkdir()
        (folder / "part.exr").write_bytes(b"a part")
        when = time.time() - 86_400 * days
        os.utime(folder, (when, when))
    for name, sha in sums.items():
        with files.local({name: sha}) as root:
            assert (root / name).read_bytes() == name.encode() * 1000
    assert (begun / "part.exr").exists() and not given_up.exists()
    kept = [path for path in tmp_path.rglob("*.exr") if path.parent != begun]
    assert [path.name for path in kept] == ["b.exr"]


def test_many_readers_share_a_small_cache(tmp_path: Path) -> None:
    """Each finds what it reads, while the others make room for what they read."""
    size, most = 20_000, 60_000
    source = tmp_path / "source"
    source.mkdir()
    for number in range(20):
        (source / f"{number}.exr").write_bytes(random.Random(number).randbytes(size))
    sums = {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in source.iterdir()}
    files = RemoteFiles(f"file://{source}", tmp_path / "cache", most)

    def read(seed: int) -> None:
        for name in random.Random(seed).choices(sorted(sums), k=40):
            with files.local({name: sums[name]}) as root:
                assert hashlib.sha256((root / name).read_bytes()).hexdigest() == sums[name]

    with ThreadPoolExecutor(4) as readers:
        list(readers.map(read, range(4)))
    assert sum(path.stat().st_size for path in (tmp_path / "cache").rglob("*.exr")) <= most + size


def test_the_cache_is_of_bounded_size(server: Server, dataset: Path, tmp_path: Path) -> None:
    size = (dataset / "renders/room_one/main/view_0/channels.exr").stat().st_size
    source = open_source(server.url, cache=tmp_path, most_cached=int(2.5 * size))
    for index in (0, 1, 0, 2):
        source.read(index, CHANNELS)
        kept = list(tmp_path.glob("*/**/*.exr"))
        assert sum(path.stat().st_size for path in kept) <= 2.5 * size
    # The one that was not read for longest went.
    assert sorted(path.parent.relative_to(path.parents[4]).as_posix() for path in kept) == [
        "renders/room_one/main/view_0",
        "renders/room_one/mainDiffMat/view_0",
    ]
    assert len([path for path in server.asked if path.endswith(".exr")]) == 3


def test_what_is_not_what_the_index_says_is_refused(dataset: Path, tmp_path: Path) -> None:
    memory = fsspec.filesystem("memory")
    memory.put(str(dataset), "/changed", recursive=True)
    index = memory.cat_file("/changed/index.jsonl").decode()
    path = "/changed/renders/room_one/main/view_0/channels.exr"
    memory.pipe_file(path, memory.cat_file(path)[::-1])
    source = open_source("memory://changed", cache=tmp_path)
    with pytest.raises(InputError, match="its checksum differs"):
        source.read(0, CHANNELS)
    assert not list(tmp_path.glob("*/**/*.exr"))
    assert "room_one" in index
    source.read(1, CHANNELS)
    memory.rm("/changed", recursive=True)
    with pytest.raises(InputError, match="no such file"):
        source.read(2, CHANNELS)


def test_a_url_without_a_dataset_is_told(server: Server, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"neither index\.jsonl nor .* nor manifest\.json"):
        open_source(f"{server.url}/renders", cache=tmp_path)
    with pytest.raises(InputError, match="not a URL that can be opened"):
        open_source("nonsense://there", cache=tmp_path)


def test_paths_do_not_leave_the_cache(tmp_path: Path) -> None:
    files = RemoteFiles("memory://evil", tmp_path / "cache")
    with (
        pytest.raises(InputError, match="leads out of the folder"),
        files.local({"../../out": "0" * 64}),
    ):
        pass
    assert not (tmp_path / "out").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["cache"]


@pytest.fixture
def bucket(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A bucket of a server on this machine, which all of this process finds."""
    pytest.importorskip("s3fs")
    server = pytest.importorskip("moto.server").ThreadedMotoServer(
        ip_address="127.0.0.1", port=0, verbose=False
    )
    server.start()
    host, port = server.get_host_and_port()
    for name, value in {
        "AWS_ACCESS_KEY_ID": "nobody",
        "AWS_SECRET_ACCESS_KEY": "nothing",
        "AWS_DEFAULT_REGION": "us-east-1",
        "AWS_ENDPOINT_URL": f"http://{host}:{port}",
    }.items():
        monkeypatch.setenv(name, value)
    yield "views"
    server.stop()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_a_bucket_gives_the_views_of_the_folder(bucket: str, dataset: Path, tmp_path: Path) -> None:
    import s3fs

    system = s3fs.S3FileSystem(skip_instance_cache=True)
    system.mkdir(bucket)
    system.put(str(dataset), f"{bucket}/small", recursive=True)
    here = open_source(dataset, split="train")
    there = open_source(f"s3://{bucket}/small", split="train", cache=tmp_path)
    assert len(there) == len(here) == 4
    for index in (0, 3):
        a, b = here.read(index, CHANNELS), there.read(index, CHANNELS)
        assert a.name == b.name
        np.testing.assert_array_equal(a.K, b.K)
        for name in CHANNELS:
            np.testing.assert_array_equal(a.images[name], b.images[name])
