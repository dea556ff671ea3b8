"""Files behind URLs: what goes wrong there is told, and no password with it."""

import sys

import pytest

from openrooms_usd import urls
from openrooms_usd.errors import InputError, MissingPackageError, OutputError

pytest.importorskip("fsspec")

SECRET = "s3://me:swordfish@bucket/views"


def test_passwords_stand_in_no_message(monkeypatch: pytest.MonkeyPatch) -> None:
    assert urls.shown(f"a {SECRET} b http://c/d@e") == "a s3://bucket/views b http://c/d@e"
    for raised in (OSError(f"no {SECRET}"), FileNotFoundError(SECRET)):
        with pytest.raises(InputError) as told, urls.reading(SECRET):
            raise raised
        assert "swordfish" not in str(told.value) and "s3://bucket/views" in str(told.value)
    monkeypatch.setitem(sys.modules, "fsspec", None)
    with pytest.raises(MissingPackageError) as missing:
        urls.file_system(SECRET)
    assert "swordfish" not in str(missing.value) and "openrooms-usd[remote]" in str(missing.value)


def test_what_is_ours_stays_as_it_is() -> None:
    with pytest.raises(OutputError, match="full"), urls.reading("memory://a"):
        raise OutputError("the disk is full")
    with pytest.raises(urls.MissingFileError, match="no such file"), urls.reading("memory://a"):
        raise FileNotFoundError


def test_a_url_leads_into_its_file_system() -> None:
    system, root = urls.file_system("memory://a/b")
    system.pipe_file(f"{root}/c.txt", b"text")
    assert urls.file_system("memory://a/b") == (system, root)
    assert urls.file_system("memory://a")[0].cat_file("/a/b/c.txt") == b"text"
    with pytest.raises(InputError, match="not a URL that can be opened"):
        urls.file_system("nonsense://there")
