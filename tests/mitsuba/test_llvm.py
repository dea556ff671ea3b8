"""Which LLVM library Dr.Jit is given: the user's, a package's, the system's, in this order."""

import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement

from orusd_mitsuba import llvm, variants
from orusd_mitsuba.llvm import Library

ROOT = Path(__file__).parents[2]


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Path]]:
    """A machine without LLVM, on which libraries are put as files of the system or of packages."""
    monkeypatch.delenv(llvm.VARIABLE, raising=False)
    monkeypatch.delitem(sys.modules, "drjit", raising=False)
    monkeypatch.setattr(llvm, "_FOLDERS", (f"{tmp_path.as_posix()}/system*",))
    found: dict[str, str] = {}

    def version(name: str) -> str:
        try:
            return found[name]
        except KeyError:
            raise llvm.metadata.PackageNotFoundError(name) from None

    class Recorded(type(tmp_path)):  # type: ignore[misc]
        def locate(self) -> Path:
            return tmp_path / "site" / self

    def files(name: str) -> list[Any]:
        return [Recorded(p.relative_to(tmp_path / "site")) for p in (tmp_path / "site").rglob("*")]

    monkeypatch.setattr(llvm.metadata, "version", version)
    monkeypatch.setattr(llvm.metadata, "files", files)

    def put(file: str, package: str = "") -> Path:
        path = tmp_path / ("site" if package else "system") / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        if package:
            found[package] = "1.2"
        for made in (llvm._versions, llvm._packaged, llvm._installed):
            made.cache_clear()
        return path

    for made in (llvm._versions, llvm._packaged, llvm._installed):
        made.cache_clear()
    yield put
    for made in (llvm._versions, llvm._packaged, llvm._installed):
        made.cache_clear()


def test_without_any_what_drjit_finds_is_tried(machine: Any) -> None:
    assert [library.path for library in llvm.libraries()] == [None]


def test_a_package_comes_before_the_system_and_newer_ones_of_the_system_first(machine: Any) -> None:
    new, newest = machine("libLLVM.so.19.1"), machine("libLLVM-99.so.1")
    packaged = machine("llvm_nanobind.libs/libLLVM-a6b1.so.21.1", "llvm-nanobind")
    assert [library.path for library in llvm.libraries()] == [packaged, newest, new, None]
    assert "llvm-nanobind 1.2" in str(next(llvm.libraries()))


@pytest.mark.parametrize(
    "file",
    ["llvm_nanobind.libs/libLLVM-a6b1.so.21", "llvm_nanobind.dylibs/l99c.dylib", "llvm/LLVM.dll"],
)
def test_the_package_of_each_system_is_found(machine: Any, file: str) -> None:
    machine("llvm_nanobind.libs/libxml2-39f6.so.2", "llvm-nanobind")
    library = machine(file, "llvm-nanobind")
    assert next(llvm.libraries()).path == library


def test_what_a_library_depends_on_is_loaded_before_it(
    machine: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("libLLVM.so.19.1", "lib/libc++.so.1.0", "lib/libunwind.so.1.0", "lib/libc++abi.so.1.0")
    library, runtime, unwinder, abi = (machine(name, "karellen-llvm-core") for name in names)
    found = next(llvm.libraries())
    assert (found.path, found.dependencies) == (library, (unwinder, abi, runtime))
    loaded: list[str] = []
    monkeypatch.setattr(llvm.ctypes, "CDLL", loaded.append)
    found.prepare()
    assert loaded == [str(path) for path in found.dependencies]
    # Processes that start from here inherit the name, and need the same.
    assert list(llvm.libraries()) == [found]


def test_what_the_user_names_is_meant(machine: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    machine("llvm_nanobind.libs/libLLVM-a6b1.so.21.1", "llvm-nanobind")
    monkeypatch.setenv(llvm.VARIABLE, "/own/libLLVM.so")
    assert [library.path for library in llvm.libraries()] == [Path("/own/libLLVM.so")]
    # Nothing that is installed would be used: the variable has to go first.
    assert llvm.remedy().startswith(f"unset the environment variable {llvm.VARIABLE}")


def test_a_library_that_is_loaded_already_cannot_be_exchanged(
    machine: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine("llvm_nanobind.libs/libLLVM-a6b1.so.21.1", "llvm-nanobind")
    monkeypatch.setitem(sys.modules, "drjit", sys)
    (only,) = llvm.libraries()
    assert only.path is None and "imported before" in only.origin


def test_old_ones_are_not_even_tried(machine: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(variants, "_probe", lambda *_: pytest.fail("it is tried"))
    assert Library(None, "here", version=(15, 1)).too_old
    assert not Library(None, "here", version=(17, 0)).too_old and not Library(None, "here").too_old
    detail = variants._llvm(Library(Path("/a/libLLVM-15.so"), "x", (), (15,))).detail
    assert detail == "LLVM 15 is too old, 17 or newer is needed"
    assert "no such file" in variants._llvm(Library(Path("/nowhere/libLLVM.so"), "x")).detail


def test_what_the_user_names_may_be_too_old(machine: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(llvm.VARIABLE, "/usr/lib/llvm-15/lib/libLLVM-15.so.1")
    assert next(llvm.libraries()).too_old


@pytest.mark.parametrize(
    ("system", "processor", "python", "package"),
    [
        ("linux", "x86_64", (3, 11), "karellen-llvm-core"),
        ("linux", "x86_64", (3, 12), "llvm-nanobind"),
        ("linux", "aarch64", (3, 14), "llvm-nanobind"),
        ("darwin", "arm64", (3, 13), "llvm-nanobind"),
        ("win32", "AMD64", (3, 12), "llvm-nanobind"),
        ("darwin", "arm64", (3, 11), None),
        ("linux", "riscv64", (3, 13), None),
    ],
)
def test_the_remedy_is_the_package_that_has_a_wheel(
    machine: Any,
    monkeypatch: pytest.MonkeyPatch,
    system: str,
    processor: str,
    python: tuple[int, int],
    package: str | None,
) -> None:
    monkeypatch.setattr(llvm.sys, "platform", system)
    monkeypatch.setattr(llvm.platform, "machine", lambda: processor)
    monkeypatch.setattr(llvm.sys, "version_info", python)
    advice = llvm.remedy()
    assert advice.startswith(f"pip install {package}; or " if package else "install LLVM 17")
    # It is what the installation brings there.
    version = ".".join(map(str, python))
    there = {"sys_platform": system, "platform_machine": processor, "python_version": version}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    brought = [
        found.name
        for found in map(Requirement, project["dependencies"])
        if found.name in llvm.PACKAGES and found.marker and found.marker.evaluate(there)
    ]
    assert brought == ([package] if package else [])


def test_here_it_is_a_package_of_pip(vectorized: str) -> None:
    """What `pip install openrooms-usd` brings is what renders, whatever the system has."""
    if "llvm" not in vectorized or llvm._package_for_this_machine() is None:
        pytest.skip("no package with LLVM has a wheel for this machine")
    assert "package " in variants.diagnose()["llvm"], variants.diagnose()
