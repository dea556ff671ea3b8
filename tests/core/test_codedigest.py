"""The digest of code: what counts for it, and what does not."""

import compileall
import shutil
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from openrooms_usd import codedigest, sourcetext
from openrooms_usd.codedigest import code_digest, library_versions, modules
from openrooms_usd.threads import mapped

ROOT = Path(__file__).parents[2]
FOLDERS = {
    "openrooms_usd": ROOT,
    **{path.name: path.parent for path in (ROOT / "converters").glob("orusd_*")},
}
MODULES = sorted(
    ".".join(file.relative_to(home).with_suffix("").parts).removesuffix(".__init__")
    for top, home in FOLDERS.items()
    for file in (home / top).rglob("*.py")
)
# Not in the core's own packages, so that nothing of ours is in the way.
PACKAGE = "orusd_sample"
SAMPLE = {
    "__init__.py": "from orusd_sample import heavy\n",
    "heavy.py": "HEAVY = 1\n",
    "inner/__init__.py": "from orusd_sample.inner import other\nNAME = 1\n",
    "inner/leaf.py": "LEAF = 1\n",
    "inner/other.py": "OTHER = 1\n",
    "table.py": 'from pathlib import Path\nFILE = Path(__file__).with_name("numbers.json")\n',
    "numbers.json": "[1,\n 2]\n",
    "idle.json": "[]\n",
}


def forget() -> None:
    for known in vars(codedigest).values():
        if hasattr(known, "cache_clear"):
            known.cache_clear()


@pytest.fixture(autouse=True)
def _forgetting() -> Iterator[None]:
    forget()
    yield
    forget()


Write = Callable[[str, str], None]


def changed(name: str) -> str:
    """A file of the sample with something added that counts."""
    return SAMPLE[name] + ("PLANTED = 1\n" if name.endswith(".py") else "\n")


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Writes one file of a package that can be imported."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(name: str, text: str) -> None:
        file = tmp_path / PACKAGE / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(text.encode())
        forget()

    for name, text in SAMPLE.items():
        write(name, text)
    return write


@pytest.mark.parametrize(
    ("source", "file"),
    [
        ("import orusd_sample.inner.leaf\n", "inner/leaf.py"),
        ("import orusd_sample.inner.leaf as leaf\n", "inner/leaf.py"),
        ("import os, orusd_sample.inner.leaf as leaf, re\n", "inner/leaf.py"),
        ("from orusd_sample.inner import leaf\n", "inner/leaf.py"),
        ("from orusd_sample.inner import NAME, leaf as x\n", "inner/leaf.py"),
        (
            "from orusd_sample.inner import (\n    NAME,  # (a)\n    leaf,  # b\n)\n",
            "inner/leaf.py",
        ),
        ("from orusd_sample.inner import NAME, \\\n    leaf\n", "inner/leaf.py"),
        ("from orusd_sample.inner.leaf import LEAF\n", "inner/leaf.py"),
        ("from orusd_sample.inner.leaf import *\n", "inner/leaf.py"),
        ("from orusd_sample.inner import *\n", "inner/__init__.py"),
        ("from orusd_sample.inner import NAME\n", "inner/other.py"),
        ("from .inner import leaf\n", "inner/leaf.py"),
        ("from .inner.leaf import LEAF\n", "inner/leaf.py"),
        ("from . import heavy\n", "heavy.py"),
        ("def f():\n    from orusd_sample.inner import leaf\n", "inner/leaf.py"),
        ("try:\n\timport orusd_sample.inner.leaf\nexcept ImportError:\n\tpass\n", "inner/leaf.py"),
        ("if TYPE_CHECKING:\n    import x\nfrom orusd_sample import heavy\n", "heavy.py"),
        ("if TYPE_CHECKING:\n    import x\nelse:\n    from . import heavy\n", "heavy.py"),
        ("import orusd_sample.table\n", "table.py"),
        ("import orusd_sample.table\n", "numbers.json"),
    ],
)
def test_the_code_of_what_is_imported_counts(write: Write, source: str, file: str) -> None:
    write("root.py", source)
    before = code_digest("orusd_sample.root")
    write(file, changed(file))
    assert code_digest("orusd_sample.root") != before
    write(file, SAMPLE[file])
    assert code_digest("orusd_sample.root") == before


@pytest.mark.parametrize(
    ("source", "file"),
    [
        ("from orusd_sample.inner import leaf\n", "__init__.py"),
        ("from orusd_sample.inner import leaf\n", "inner/__init__.py"),
        ("from orusd_sample.inner.leaf import LEAF\n", "inner/other.py"),
        ("if TYPE_CHECKING:\n    from orusd_sample import heavy\n\n    import x\n", "heavy.py"),
        ("import orusd_sample.table\n", "idle.json"),
        ("heavy = 1  # no import orusd_sample.heavy\n", "heavy.py"),
    ],
)
def test_what_is_not_used_does_not_count(write: Write, source: str, file: str) -> None:
    write("root.py", source)
    before = code_digest("orusd_sample.root")
    write(file, changed(file))
    assert code_digest("orusd_sample.root") == before


PLAIN = "class A:\n    x: int = 1\n\n    def f(self, y=2):\n        return f'{y} x'\n"
SPOKEN = """'''A module.'''  # with a remark

class A:
    '''A class.'''
    x: int = 1
    '''An attribute.'''
    # Why.
    def f(
        self, y=2,
    ):
        '''A function.'''
        return f"{y} x"
"""


def test_comments_docstrings_and_layout_do_not_count(write: Write) -> None:
    write("root.py", PLAIN)
    before = code_digest("orusd_sample.root")
    write("root.py", SPOKEN)
    assert code_digest("orusd_sample.root") == before


@pytest.mark.parametrize(
    ("old", "new"),
    [("= 1", "= 1.0"), ("y=2", "y=-2"), ("int", "float"), ("} x", "}  x"), ("self, ", "self, *, ")],
)
def test_everything_else_counts(write: Write, old: str, new: str) -> None:
    write("root.py", PLAIN)
    before = code_digest("orusd_sample.root")
    write("root.py", PLAIN.replace(old, new))
    assert code_digest("orusd_sample.root") != before


def test_what_is_no_python_counts_byte_by_byte(write: Write) -> None:
    write("root.py", "def (\n")
    before = code_digest("orusd_sample.root")
    write("root.py", "def ( # more\n")
    assert code_digest("orusd_sample.root") != before


@pytest.mark.parametrize("spoilt", ["", "[]", '{"a": 1}', '{"a": ["", [["b", 2]], 3]}'])
def test_digests_are_the_same_without_and_with_any_cache(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, spoilt: str
) -> None:
    write("root.py", "import orusd_sample.table\nimport orusd_sample.inner\n")

    def digest(cache: str) -> str:
        monkeypatch.setenv("ORUSD_CACHE", cache)
        forget()
        return code_digest("orusd_sample.root")

    before, cache = digest("off"), str(tmp_path / "cache")
    assert digest(cache) == before
    [kept] = (tmp_path / "cache/code").iterdir()
    with monkeypatch.context() as patch:
        patch.setattr(sourcetext, "_parse", lambda source: pytest.fail("parsed again"))
        assert digest(cache) == before
    kept.write_text(spoilt)
    assert digest(cache) == before


def test_all_modules_of_a_package_count_and_which_there_are(write: Write) -> None:
    before = code_digest("orusd_sample.inner.*")
    found = {"orusd_sample.inner.leaf", "orusd_sample.inner.other"}
    assert set(modules("orusd_sample.inner.*")) == found
    write("inner/leaf.py", changed("inner/leaf.py"))
    second = code_digest("orusd_sample.inner.*")
    write("inner/more.py", "")
    assert len({before, second, code_digest("orusd_sample.inner.*")}) == 3


def test_modules_apart_do_not_count(write: Write) -> None:
    write("root.py", "from orusd_sample import heavy\n")
    assert modules("orusd_sample.root", apart=("orusd_sample.heavy",)) == ("orusd_sample.root",)


def test_what_is_counted_while_something_is_made() -> None:
    made = []

    @codedigest.remembered
    def make(name: str) -> str:
        codedigest.count(f"of_{name}")
        made.append(name)
        return name

    def gathered(*names: str) -> set[str]:
        with codedigest.counting() as found:
            list(mapped(make, names, workers=3))
        return found

    assert gathered("a", "b") == {"of_a", "of_b"}
    # Made once, and counted for each that needs it, by itself or within another.
    with codedigest.counting() as outer:
        assert gathered("b") == {"of_b"}
    assert outer == {"of_b"}
    assert sorted(made) == ["a", "b"]
    assert gathered() == set()


def test_of_leaves_the_text_counts_and_not_what_they_import(write: Write) -> None:
    write("root.py", "from orusd_sample import inner\n")

    def digest() -> str:
        return code_digest("orusd_sample.root", leaves=("orusd_sample.inner",))

    before = digest()
    write("inner/other.py", "OTHER = 2\n")
    assert digest() == before
    write("inner/__init__.py", "NAME = 2\n")
    assert digest() != before


def test_line_ends_and_places_do_not_count(write: Write, tmp_path: Path) -> None:
    write("root.py", "import orusd_sample.table\nimport orusd_sample.inner\n")
    before = code_digest("orusd_sample.root")
    for name in ("root.py", "table.py", "numbers.json", "inner/__init__.py"):
        file = tmp_path / PACKAGE / name
        write(name, file.read_text().replace("\n", "\r\n"))
    assert code_digest("orusd_sample.root") == before


def test_in_other_folders_and_archives_it_is_the_same(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("root.py", "import orusd_sample.table\nimport orusd_sample.inner\n")
    before = code_digest("orusd_sample.root")
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    (tmp_path / PACKAGE).rename(moved / PACKAGE)
    with zipfile.ZipFile(tmp_path / "code.zip", "w") as archive:
        for file in moved.rglob("*.*"):
            archive.write(file, file.relative_to(moved).as_posix())
    forget()
    assert modules("orusd_sample.root") == ("orusd_sample.root",)
    for place in (moved, tmp_path / "code.zip"):
        with monkeypatch.context() as patch:
            patch.syspath_prepend(place)
            forget()
            assert code_digest("orusd_sample.root") == before
            assert "orusd_sample.inner.other" in modules("orusd_sample.root")


def test_without_source_the_version_stands_for_the_code(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("root.py", "import orusd_sample.table\n")
    whole = code_digest("orusd_sample.root")
    compileall.compile_dir(tmp_path / PACKAGE, quiet=1, legacy=True)
    for file in (tmp_path / PACKAGE).rglob("*.py"):
        file.unlink()
    forget()
    bare = code_digest("orusd_sample.root")
    assert bare != whole
    forget()
    monkeypatch.setattr(codedigest, "__version__", "99")
    assert code_digest("orusd_sample.root") != bare


@pytest.mark.parametrize("name", ["no_such_package.module", "__main__", "openrooms_usd.no_such"])
def test_modules_that_cannot_be_found_are_taken_by_their_version(name: str) -> None:
    assert len(code_digest(name)) == 64


def test_the_versions_of_what_others_wrote_are_told_apart(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("root.py", "import json\ndef f():\n    import numpy.linalg\n    from pxr import Usd\n")
    found = library_versions("orusd_sample.root")
    assert [line.partition(" ")[0] for line in found] == ["numpy", "usd-core"]
    before = code_digest("orusd_sample.root")
    (tmp_path / "numpy-0.1.dist-info").mkdir()
    (tmp_path / "numpy-0.1.dist-info" / "METADATA").write_text("Name: numpy\nVersion: 0.1\n")
    forget()
    assert library_versions("orusd_sample.root")[0] == "numpy 0.1"
    assert code_digest("orusd_sample.root") == before


def test_every_file_of_data_counts_for_some_module() -> None:
    # Written out for people by commands; no step reads them.
    by_hand = {
        "starter.yaml",
        "room.yaml",
        "sky.exr",
        "page.css",
        "py.typed",
        "hosek_wilkie.LICENSE.txt",
    }
    there = {
        path.name
        for path in (ROOT / "openrooms_usd").rglob("*.*")
        if path.is_file()
        and path.suffix not in (".py", ".pyc")
        # The pages of `orusd view`, that browsers read.
        and path.parent != ROOT / "openrooms_usd/view/page"
    }
    read = [codedigest._module(name) for name in MODULES]
    assert {file for module in read if module for file in module.data} == there - by_hand


def test_a_copy_of_the_package_has_the_same_digest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = code_digest("openrooms_usd.steps.layout.step")
    shutil.copytree(
        ROOT / "openrooms_usd",
        tmp_path / "openrooms_usd",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    spec = codedigest._spec("openrooms_usd")
    assert spec is not None
    forget()
    monkeypatch.setattr(spec, "origin", str(tmp_path / "openrooms_usd" / "__init__.py"))
    assert code_digest("openrooms_usd.steps.layout.step") == before
    with (tmp_path / "openrooms_usd" / "names.py").open("a") as file:
        file.write("PLANTED = 1\n")
    forget()
    assert code_digest("openrooms_usd.steps.layout.step") != before
