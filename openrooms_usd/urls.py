"""Files behind URLs, which fsspec opens (extra ``remote``): ``s3://``, ``http://``, ``memory://``.

Who may read and write there is known from where the packages of fsspec look, as the environment.
What a URL itself says of that stands in no message.
"""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, Final

from openrooms_usd.errors import InputError, MissingPackageError, OrusdError

_SECRET: Final = re.compile(r"(?<=://)[^/@\s]*@")


class MissingFileError(InputError):
    """Nothing is behind a path of a URL."""


def is_url(text: str) -> bool:
    """Whether a text reads like a URL, and not like a path."""
    return "://" in text


def shown(text: object) -> str:
    """A text for people in which URLs may stand, without the names and passwords in them."""
    return _SECRET.sub("", str(text))


def file_system(url: str) -> tuple[Any, str]:
    """What opens the files behind a URL, and where in it the URL leads, without a slash at the end.

    Raises:
        InputError: It is not a supported URL.
        MissingPackageError: fsspec, or what it needs for such URLs, is not installed.
    """
    return _file_system(url, os.getpid())


@lru_cache(maxsize=8)
def _file_system(url: str, process: int) -> tuple[Any, str]:
    """One for each process: connections do not survive a fork."""
    try:
        import fsspec

        # What others put there meanwhile is seen.
        system, root = fsspec.core.url_to_fs(
            url, use_listings_cache=False, skip_instance_cache=True
        )
    except ImportError as error:
        raise MissingPackageError(
            f"{shown(url)} needs a package that cannot be imported ({error})",
            remedy="pip install 'openrooms-usd[remote]'; for s3:// also s3fs",
        ) from error
    except ValueError as error:
        raise InputError(
            f"not a URL that can be opened: {shown(error)}",
            place=shown(url),
            remedy="check its scheme: s3://, http://, or another one of fsspec",
        ) from error
    return system, root.rstrip("/")


@contextmanager
def reading(url: str) -> Iterator[None]:
    """Turn what goes wrong behind a URL while something is read there into an `InputError`.

    Args:
        url: What is read.

    Raises:
        MissingFileError: Nothing is there.
        InputError: It cannot be read.
    """
    try:
        yield
    except OrusdError:
        raise
    except FileNotFoundError as error:
        raise MissingFileError("no such file", place=shown(url), remedy="check the URL") from error
    # What stands behind a URL raises what it likes.
    except Exception as error:
        raise unreadable(url, error) from error


def unreadable(url: str, error: BaseException) -> InputError:
    """Why something behind a URL cannot be read."""
    return InputError(
        f"cannot read it: {shown(error) or type(error).__name__}",
        place=shown(url),
        remedy="check the URL and your permission to read",
    )
