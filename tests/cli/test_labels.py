"""`orusd labels` was called `annotate`: its old words go on working, and say so."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from openrooms_usd.cli import orusd
from openrooms_usd.errors import OrusdError


def said(*words: str) -> Result:
    return CliRunner().invoke(orusd, words, standalone_mode=False)


@pytest.mark.parametrize("order", [("r", "-o", "f.json"), ("--out=f.json", "r"), ("-of.json", "r")])
def test_old_words_do_what_labels_does(
    order: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    new, old = said("labels", *order), said("annotate", *order)
    assert isinstance(new.exception, OrusdError) and isinstance(old.exception, OrusdError)
    assert str(old.exception) == str(new.exception)
    assert not new.stderr and old.stderr == "note: `annotate` is called `labels` now\n"
    assert not old.stdout


def test_annotate_alone_says_what_it_is() -> None:
    told = said("annotate", "--help")
    assert told.exit_code == 0 and "browser" in told.stdout


def test_an_unknown_page_is_none() -> None:
    told = said("annotate", "walls")
    assert "No such command 'walls'" in str(told.exception) and not told.stderr
