"""Ray: a cluster that is there, or one of our own on this machine, for as long as it is used.

One of our own listens on the loopback interface alone and takes only who knows a random word; it
has no dashboard and sends no statistics.
"""

import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from types import ModuleType
from typing import Any, Final

from openrooms_usd.errors import InputError, MissingPackageError

# What Ray keeps of objects that are handed over: tasks are small.
_OBJECT_STORE_BYTES: Final = 128 * 2**20
_CLIENT: Final = "ray://"
# Else it says on standard output who has died, and warns of workers without a GPU.
_QUIET: Final = {"RAY_DEDUP_LOGS_SKIP_REGEX": ".", "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0"}


@contextmanager
def connected(address: str | None, cpus: int) -> Iterator[ModuleType]:
    """Ray, connected to a cluster, or to one that lasts as long as the block.

    Args:
        address: The cluster, as Ray writes it; None for one of our own on this machine.
        cpus: Processors that this one has for its workers.

    Yields:
        The package.

    Raises:
        InputError: No cluster is there.
        MissingPackageError: Ray is not installed.
    """
    if address is not None and address.startswith(_CLIENT):
        raise InputError(
            "workers cannot be heard through Ray's client",
            place=address,
            remedy="run this on a machine of the cluster, with --address auto",
        )
    quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": "critical"}
    with _environment({} if address else _own()):
        ray = _package()
        try:
            if address is not None:
                ray.init(address=address, **quiet)
            else:
                ray.init(
                    address="local",
                    num_cpus=cpus,
                    object_store_memory=_OBJECT_STORE_BYTES,
                    include_dashboard=False,
                    _node_ip_address="127.0.0.1",
                    **quiet,
                )
        except (ConnectionError, ValueError, RuntimeError, OSError) as error:
            raise InputError(
                f"no cluster of Ray is there: {str(error).partition(chr(10))[0]}",
                place=address or "this machine",
                remedy="start one (ray start --head), and give its HOST:PORT",
            ) from error
        try:
            yield ray
        finally:
            ray.shutdown()


@cache
def _own() -> Mapping[str, str]:
    """The environment of a Ray of one's own."""
    return {
        # What Ray does for macOS and Windows: listen on the loopback interface alone.
        "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0",
        "RAY_AUTH_MODE": "token",
        "RAY_AUTH_TOKEN": secrets.token_hex(32),
        "RAY_USAGE_STATS_ENABLED": "0",
    }


@contextmanager
def _environment(added: Mapping[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in added}
    os.environ.update(added)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _package() -> ModuleType:
    for name, value in _QUIET.items():
        os.environ.setdefault(name, value)
    try:
        import ray
    except ImportError as error:
        raise MissingPackageError(
            f"the executor 'ray' needs the package 'ray', which cannot be imported ({error})",
            remedy="pip install openrooms-usd[ray], or leave --executor away",
        ) from error
    found: ModuleType = ray
    return found
