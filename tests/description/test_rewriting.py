"""One section's keys change; every other byte of a room.yaml stays, comments too."""

import pytest

from openrooms_usd.description.reading import read_yaml
from openrooms_usd.description.rewriting import rewritten
from openrooms_usd.errors import DescriptionError

COMMENTED = """\
# Größe: metres
name: x   # a name
layout:
  # where from
  from: scan   # why
  scan: "a b.ply"
  height: 240 cm  # high

  # the end of it
furniture: {from: scan}
"""
WANTED = {"height": 2.5, "openings": [{"kind": "door", "wall": 0}], "partitions": None}


def test_comments_blank_lines_and_quotes_stay() -> None:
    assert rewritten(COMMENTED, "layout", WANTED) == COMMENTED.replace(
        "240 cm  # high\n", "2.5  # high\n  openings:\n    - {kind: door, wall: 0}\n"
    )


def test_a_key_that_is_added_and_left_out_again_leaves_the_same_bytes() -> None:
    more = rewritten(COMMENTED, "layout", {"openings": [], "polygon": [[0, 0.5], [1, 2]]})
    assert rewritten(more, "layout", {"openings": None, "polygon": None}) == COMMENTED


@pytest.mark.parametrize(
    "text",
    [
        COMMENTED,
        COMMENTED.replace("\n", "\r\n"),
        "\ufeff" + COMMENTED,
        "room: office",
        "layout:\nroom: misc\n",
        "layout: {}\n",
        "{room: misc}",
        "layout: {from: roomplan, file: a.json, height: 3}\n",
        "layout:\n  openings: # these\n    - kind: door\n      wall: 0 # k\n  # e\n  height: 3\n",
        "layout:\n  scan: |\n    a\n  height: 3\n\n\ncameras: {}\n",
    ],
)
def test_what_is_read_again_differs_in_these_keys_alone(text: str) -> None:
    before, _ = read_yaml(text, "room.yaml")
    after, mistakes = read_yaml(rewritten(text, "layout", WANTED), "room.yaml")
    held = before.pop("layout", None) or {}
    assert mistakes == []
    assert after.pop("layout") == {**held, "height": 2.5, "openings": WANTED["openings"]}
    assert after == before


def test_long_lists_of_numbers_are_wrapped_and_read_the_same() -> None:
    corners = [[round(0.1234 * i, 4), i] for i in range(60)]
    made = rewritten(COMMENTED, "layout", {"polygon": corners})
    assert max(map(len, made.splitlines())) <= 100
    assert read_yaml(made, "room.yaml")[0]["layout"]["polygon"] == corners


@pytest.mark.parametrize("word", ["true", "No", "it's", "a: b", " x", "é\n", "1", "#", "", "-"])
def test_text_stays_text(word: str) -> None:
    made = rewritten("room: misc\n", "layout", {"file": word, "other": [{"k": word}]})
    assert read_yaml(made, "room.yaml")[0]["layout"] == {"file": word, "other": [{"k": word}]}


def test_what_an_alias_stands_for_is_not_torn_out() -> None:
    text = "layout:\n  height: &h 3\nfurniture:\n  other: *h\n"
    with pytest.raises(DescriptionError, match="does not let parts of it be changed"):
        rewritten(text, "layout", {"height": 2.5})
