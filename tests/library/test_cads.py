"""CADs to choose from: a folder of meshes with its index, and the library's own styles."""

import json
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.furniture import category
from openrooms_usd.library.models.cads import folder_cads, furniture_cads, merged

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def written(folder: Path, index: dict[str, object] | None = None) -> Path:
    (folder / "chairs").mkdir(parents=True)
    (folder / "chairs" / "a.obj").write_text(TETRAHEDRON)
    (folder / "b.obj").write_text(TETRAHEDRON)
    if index is not None:
        (folder / "index.json").write_text(json.dumps(index))
    return folder


def test_the_index_says_what_the_files_do_not(tmp_path: Path) -> None:
    index = {"b": {"category": "sofa", "up": "Z", "front": "+X", "symmetry": "2"}}
    a, b = folder_cads(written(tmp_path / "cad", index))
    assert (a.id, a.category, a.up, a.front) == ("a", "chairs", None, "-Y")
    assert (b.id, b.category, b.up, b.front, b.symmetry) == ("b", "sofa", "Z", "+X", "2")


def test_meshes_come_back_in_the_frame_of_their_file(tmp_path: Path) -> None:
    (_, b) = folder_cads(written(tmp_path / "cad", {"b": {"up": "Z", "front": "+X"}}))
    model = b.model()
    vertices, faces = merged(model, model.file_from_object)
    assert len(faces) == 4
    found = {tuple(row) for row in np.round(vertices, 9).tolist()}
    assert found == {(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3)}


@pytest.mark.parametrize("entry", [{"front": "up"}, {"up": "X"}, {"symmetry": "7"}])
def test_what_the_index_cannot_mean_is_refused_by_name(tmp_path: Path, entry: object) -> None:
    with pytest.raises(InputError, match="one of"):
        folder_cads(written(tmp_path / "cad", {"b": entry}))


def test_an_empty_folder_and_none_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="0 meshes"):
        folder_cads(tmp_path)
    with pytest.raises(InputError, match="no such folder"):
        folder_cads(tmp_path / "none")


def test_the_library_offers_every_style(tmp_path: Path) -> None:
    cads = furniture_cads(("chair", "sofa"))
    assert {c.style for c in cads if c.category == "chair"} == set(category("chair").styles)
    size = np.ptp(cads[0].model().extent, axis=0)
    assert (size > 0.2).all()
