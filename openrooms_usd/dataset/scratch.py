"""A dataset behind a URL, as a store on this machine: what is read is fetched, what is written put.

The records of a dataset are small and are all fetched; the renders of a job only as long as they
are needed. A scratch folder goes with its process; what one that was killed has left is removed by
the next one that makes a scratch folder on that machine.
"""

import json
import os
import secrets
import socket
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from openrooms_usd import claims, processes, removal
from openrooms_usd.dataset.plan import Job, view_name
from openrooms_usd.dataset.records import SCENE
from openrooms_usd.dataset.remote import RemoteFolder
from openrooms_usd.dataset.store import FILE, KNOWN, PLAN, Store
from openrooms_usd.errors import InputError, OrusdError, OutputError
from openrooms_usd.rendering.folder import check_writable
from openrooms_usd.urls import is_url, shown

LEASE: Final = ".orusd.lease.json"
# How often the holder writes, how long one waits for that, and how long a claim is let rest.
BEAT_S: Final = 5.0
STALE_S: Final = 30.0
REST_S: Final = 1.0
Root = Path | str


"""Where a dataset lies: a folder, or a URL."""
_PREFIX: Final = "orusd.scratch."
_LOCK: Final = ".orusd.lock"
_LEDGER: Final = ".orusd.dataset.sha256"


def root_of(text: str | os.PathLike[str]) -> Root:
    """A folder, or a URL where it reads like one."""
    given = os.fspath(text)
    return given if is_url(given) else Path(given)


@contextmanager
def store_at(root: Root) -> Iterator[Store]:
    """The store of a dataset, wherever it lies; from a URL nothing is fetched yet.

    Raises:
        InputError: It is not a supported URL.
        MissingPackageError: What such URLs need is not installed.
    """
    if isinstance(root, Path):
        yield Store(root)
        return
    remote = RemoteFolder(root)
    with _scratch() as folder:
        yield Store(folder, remote)


def fetch_all(store: Store) -> None:
    """Have the plan and all that is known of its units here.

    Raises:
        InputError: There is no dataset, or it cannot be read.
    """
    if store.remote is None:
        return
    store.remote.get([FILE, PLAN], store.root)
    if not (store.root / PLAN).is_file():
        raise InputError(
            "there is no dataset", place=shown(store.remote.url), remedy="give the URL of a dataset"
        )
    fetch_known(store)


def fetch_known(store: Store) -> None:
    """Have all that is known of the units of the plan here.

    Raises:
        InputError: It cannot be read.
    """
    if store.remote is None:
        return
    # Rooms that were not started are not queried: there may be a million of them.
    begun = {part: store.remote.folders(part) for part in KNOWN}
    names = (name for job in store.jobs() for name in _names_of_views(store, job, job.views))
    known = (name.split("/", 2) for name in names)
    store.remote.get(("/".join(name) for name in known if name[1] in begun[name[0]]), store.root)


def fetch_unit(store: Store, job: Job, view: int) -> None:
    """Fetch what is known of a view that another run has made.

    Raises:
        InputError: It cannot be read.
    """
    if store.remote is not None:
        store.remote.get(_names_of_views(store, job, (view,)), store.root)


@contextmanager
def fetched(store: Store, *jobs: Job, scenes: bool = False) -> Iterator[None]:
    """Have the renders of jobs here, as long as the block lasts.

    Args:
        store: Where everything lies.
        *jobs: The jobs.
        scenes: Whether their composed rooms are needed, too.

    Raises:
        InputError: They cannot be read.
    """
    if store.remote is None:
        yield
        return
    folders = [store.render(job) for job in jobs]
    folders += [store.scene(job) for job in jobs if scenes]
    try:
        for folder in folders:
            store.remote.get_all(f"{store.name_of(folder)}/", store.root)
        yield
    finally:
        for folder in folders:
            removal.remove_tree(folder)


def _names_of_views(store: Store, job: Job, views: tuple[int, ...]) -> Iterator[str]:
    """The names of all that is known of views of a job."""
    yield store.name_of(store.record_path(job, SCENE))
    for view in views:
        yield store.name_of(store.record_path(job, view_name(view)))
        yield store.name_of(store.failure_path(job, view))
        yield store.name_of(store.timing_path(job, view))


@contextmanager
def exclusive_store(root: Root) -> Iterator[tuple[Store, Callable[[], None]]]:
    """Have a dataset to oneself.

    Yields:
        Its store, with the file that it was made by; and a check that raises `OutputError` if
        another run has taken it over.

    Raises:
        OutputError: Another run has it, or it cannot be written.
    """
    with store_at(root) as store:
        if store.remote is None:
            check_writable(store.root)
            # What lies deeper is written by workers, and known by its records.
            with claims.claimed(store.root, _LEDGER, deep=False):
                yield store, lambda: None
        else:
            with leased(store.remote) as lease:
                store.remote.get([FILE], store.root)
                yield store, lease.check


@contextmanager
def _scratch() -> Iterator[Path]:
    """An empty folder, locked as long as its process lives."""
    from filelock import FileLock

    home = Path(tempfile.gettempdir())
    _sweep(home)
    folder = Path(tempfile.mkdtemp(prefix=_PREFIX))
    try:
        with FileLock(folder / _LOCK):
            yield folder
    finally:
        # Windows removes no file that is open, such as the lock.
        removal.remove_tree(folder)


def _sweep(home: Path) -> None:
    """Remove the scratch folders of this user's processes that are gone."""
    from filelock import FileLock, Timeout

    for folder in home.glob(f"{_PREFIX}*"):
        with suppress(OSError, Timeout):
            lock = folder / _LOCK
            if folder.is_symlink() or not _is_this_users(folder) or not lock.is_file():
                continue
            with FileLock(lock, timeout=0):
                pass
            removal.remove_tree(folder)


def _is_this_users(folder: Path) -> bool:
    """On Windows each user has a folder of temporary files."""
    return sys.platform == "win32" or folder.stat().st_uid == os.getuid()


class Lease:
    """What a run has as long as it lasts.

    Args:
        remote: Where the dataset lies.
        ended: The clock: what the holder waits by, until it is set.

    Attributes:
        lost: Whether another run has taken it.
    """

    def __init__(self, remote: RemoteFolder, ended: threading.Event | None = None) -> None:
        self.lost = False
        self._remote, self._beats, self._ended = remote, 0, ended or threading.Event()
        # Whose it is, for people, and which of their runs.
        self._who = {"host": socket.gethostname(), "process": os.getpid()}
        self._run = secrets.token_hex(8)

    def check(self) -> None:
        """See that the run still has it.

        Raises:
            OutputError: Another run has taken it.
        """
        if self.lost:
            raise OutputError(
                "another run has taken over this dataset",
                place=shown(self._remote.url),
                remedy="let that run continue; finished work here stays",
            )

    def take(self) -> None:
        """Get it.

        Raises:
            OutputError: Another run has it.
        """
        if not self._remote.put_text(LEASE, self._text(), new=True):
            self._await_end()
            self._remote.remove([LEASE])
            if not self._remote.put_text(LEASE, self._text(), new=True):
                raise self._lease_error()
        self._ended.wait(REST_S)
        if not self._is_ours():
            raise self._lease_error()

    def keep(self) -> None:
        """Say that its holder is alive, until it is given back or lost."""
        while not self._ended.wait(BEAT_S) and not self.lost:
            # A server that does not answer for a moment takes nothing away.
            with suppress(OrusdError):
                self.beat()

    def beat(self) -> None:
        """Say once that its holder is alive, or find that another run has taken it."""
        self.lost = not self._is_ours()
        if not self.lost:
            self._beats += 1
            self._remote.put_text(LEASE, self._text())

    def end(self) -> None:
        """Say no more that its holder is alive."""
        self._ended.set()

    def give_back(self) -> None:
        """Release it for others."""
        with suppress(OrusdError):
            if self._is_ours():
                self._remote.remove([LEASE])

    def _await_end(self) -> None:
        """Wait until who has it is gone."""
        before = self._remote.read(LEASE)
        if self._is_of_the_dead(before):
            return
        for _ in range(int(STALE_S / REST_S)):
            self._ended.wait(REST_S)
            now = self._remote.read(LEASE)
            if now is None:
                return
            if now != before:
                raise self._lease_error(now)

    def _is_of_the_dead(self, data: bytes | None) -> bool:
        """Whether it belongs to an ended process of this machine, so that waiting is useless."""
        try:
            told = json.loads(data or b"{}")
            return bool(
                told["host"] == self._who["host"] and not processes.is_running(int(told["process"]))
            )
        except (ValueError, KeyError, TypeError, OverflowError):
            return False

    def _is_ours(self) -> bool:
        data = self._remote.read(LEASE)
        with suppress(ValueError, KeyError, TypeError):
            return bool(json.loads(data or b"{}")["run"] == self._run)
        return False

    def _text(self) -> str:
        return json.dumps({**self._who, "run": self._run, "beat": self._beats}, sort_keys=True)

    def _lease_error(self, data: bytes | None = None) -> OutputError:
        holder = "another run"
        with suppress(ValueError, KeyError, TypeError):
            told = json.loads(data or self._remote.read(LEASE) or b"{}")
            holder = f"process {int(told['process'])} of {str(told['host'])[:80]}"
        return OutputError(
            f"{holder} is running this dataset",
            place=shown(self._remote.url),
            remedy="wait until it has ended, or choose another URL",
        )


@contextmanager
def leased(remote: RemoteFolder) -> Iterator[Lease]:
    """Have a dataset behind a URL to oneself.

    Raises:
        OutputError: Another run has it, or it cannot be written.
    """
    lease = Lease(remote)
    lease.take()
    keeper = threading.Thread(target=lease.keep, daemon=True)
    keeper.start()
    try:
        yield lease
    finally:
        # What its keeper was writing would stand there again after it is removed.
        lease.end()
        keeper.join(STALE_S)
        lease.give_back()
