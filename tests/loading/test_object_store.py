"""Views in a bucket of a real server of objects: the same arrays as in the folder."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.loading.opening import open_source

CHANNELS = ("radiance", "depth", "instance")


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
