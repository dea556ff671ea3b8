"""MaterialX files that mean harm, or lack something: refused with a sentence, never a crash."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.library.ownmaterials import files_of, read_material
from openrooms_usd.library.pictures import write_png

pytest.importorskip("MaterialX")

SHADER = (
    '<standard_surface name="S" type="surfaceshader">'
    '<input name="base_color" type="color3" {}/></standard_surface>'
)
IMAGE = '<image name="I" type="color3"><input name="file" type="filename" value="{}"/></image>'
INCLUDE = '<xi:include href="{}"/>'


def write(folder: Path, body: str, *, head: str = "", name: str = "m.mtlx") -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / name
    space = 'xmlns:xi="http://www.w3.org/2001/XInclude"'
    path.write_text(
        f'<?xml version="1.0"?>{head}<materialx version="1.39" {space}>{body}</materialx>'
    )
    return path


def textured(folder: Path, file: str) -> Path:
    return write(folder, IMAGE.format(file) + SHADER.format('nodename="I"'))


ENTITIES = {
    "external": '<!DOCTYPE m [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
    "laughs": '<!DOCTYPE m [<!ENTITY a "aa"><!ENTITY b "&a;&a;"><!ENTITY c "&b;&b;">]>',
    "plain": "<!DOCTYPE materialx>",
    "lower case": "<!doctype materialx>",
}


@pytest.mark.parametrize("kind", sorted(ENTITIES))
def test_entities_are_refused(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path, SHADER.format('value="1,1,1"'), head=ENTITIES[kind])
    for read in (read_material, files_of):
        with pytest.raises(InputError, match="DOCTYPE or entities"):
            read(path)


def test_entities_in_another_encoding_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "", head=ENTITIES["external"])
    path.write_bytes(path.read_text().encode("utf-16"))
    with pytest.raises(InputError, match="not readable XML"):
        read_material(path)


BROKEN = {
    "cut": "<materialx version='1.39'><image",
    "deep": "<materialx version='1.39'>" + "<a>" * 5000 + "</a>" * 5000 + "</materialx>",
    "no XML": "once upon a time",
    "nothing": "",
    "no MaterialX": "<html/>",
    "version": "<materialx version='one'/>",
}


@pytest.mark.parametrize("kind", sorted(BROKEN))
def test_broken_files_are_refused(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "m.mtlx"
    path.write_text(BROKEN[kind])
    with pytest.raises(InputError):
        read_material(path)


def test_includes_below_the_folder_are_read(tmp_path: Path) -> None:
    write(tmp_path / "parts", SHADER.format('value="0.5, 0.25, 0.125"'), name="s.mtlx")
    path = write(tmp_path, INCLUDE.format("parts/s.mtlx"))
    assert read_material(path).surface.base_color == (0.5, 0.25, 0.125)
    assert files_of(path) == [path, tmp_path / "parts/s.mtlx"]


@pytest.mark.parametrize("absolute", [False, True])
def test_includes_outside_the_folder_are_refused(tmp_path: Path, absolute: bool) -> None:
    outside = write(tmp_path, SHADER.format('value="1,1,1"'), name="outside.mtlx")
    href = str(outside) if absolute else "../outside.mtlx"
    path = write(tmp_path / "inside", INCLUDE.format(href))
    with pytest.raises(InputError, match="lies outside its folder"):
        read_material(path)


def test_included_files_are_checked_too(tmp_path: Path) -> None:
    write(tmp_path, "", head=ENTITIES["laughs"], name="s.mtlx")
    with pytest.raises(InputError, match="DOCTYPE or entities"):
        read_material(write(tmp_path, INCLUDE.format("s.mtlx")))


def test_includes_that_include_each_other_end(tmp_path: Path) -> None:
    write(tmp_path, INCLUDE.format("m.mtlx"), name="s.mtlx")
    with pytest.raises(InputError, match="cycle"):
        read_material(write(tmp_path, INCLUDE.format("s.mtlx")))


def test_pictures_outside_the_folder_are_refused(tmp_path: Path) -> None:
    write_png(tmp_path / "secret.png", np.zeros((2, 2, 3), np.uint8), is_color=True)
    with pytest.raises(InputError, match=r"names \.\./secret\.png, which lies outside"):
        read_material(textured(tmp_path / "inside", "../secret.png"))
    (tmp_path / "inside/link.png").symlink_to(tmp_path / "secret.png")
    with pytest.raises(InputError, match="lies outside"):
        read_material(textured(tmp_path / "inside", "link.png"))


def test_the_users_own_pictures_may_be_absolute(tmp_path: Path) -> None:
    write_png(tmp_path / "mine.png", np.zeros((2, 2, 3), np.uint8), is_color=True)
    path = textured(tmp_path / "inside", str(tmp_path / "mine.png"))
    material = read_material(path)
    assert material.textures["base_color"].file == str(tmp_path / "mine.png")
    assert tmp_path / "mine.png" in files_of(path)


def test_missing_pictures_are_one_error_that_names_them(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"I\.file: .*lost\.png is missing") as caught:
        read_material(textured(tmp_path, "lost.png"))
    assert "copy them into the folder" in str(caught.value)


def test_tiles_of_pictures_are_left_out_and_named(tmp_path: Path) -> None:
    material = read_material(textured(tmp_path, "wood.&lt;UDIM&gt;.png"))
    assert material.textures == {}
    assert any("UDIM" in loss for loss in material.losses)


def test_a_grey_normal_map_is_left_out(tmp_path: Path) -> None:
    write_png(tmp_path / "n.png", np.full((4, 4), 200, np.uint8), is_color=False)
    body = (
        '<image name="I" type="vector3"><input name="file" type="filename" value="n.png"/></image>'
        '<normalmap name="N" type="vector3"><input name="in" type="vector3" nodename="I"/>'
        '</normalmap><standard_surface name="S" type="surfaceshader">'
        '<input name="normal" type="vector3" nodename="N"/></standard_surface>'
    )
    material = read_material(write(tmp_path, body))
    assert material.surface.normal == (0.0, 0.0, 1.0)
    assert any("n.png: left out" in loss for loss in material.losses)
