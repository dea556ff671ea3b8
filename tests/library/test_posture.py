"""Which way up own models stand and how long their unit is, by what their category usually is."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from openrooms_usd.furniture import category
from openrooms_usd.imagefile import write_png
from openrooms_usd.library.models.meshfile import read_model
from openrooms_usd.library.models.posture import Posture, Usual, posture, standing

Real = Callable[[str], Path]


def usual(name: str) -> Usual:
    built = category(name)
    return Usual(name, built.size, built.min_size, built.max_size)


def stands(name: str, box: tuple[float, float, float], **said: object) -> Posture:
    """How a box along a file's axes stands, its middle in the file's origin, of a Y-up format."""
    low, high = (tuple(sign * 0.5 * side for side in box) for sign in (-1, 1))
    return posture(low, high, Posture("Y", 1.0), usual(name), **said)


# Of sofas and desks, which are as deep as high, sizes do not tell it.
NAMES = ("chair", "bed", "wardrobe", "floor_lamp", "refrigerator", "bookshelf")


@pytest.mark.parametrize("up", ["Y", "Z"])
@pytest.mark.parametrize("unit", [1.0, 0.1, 0.01, 0.001])
@pytest.mark.parametrize("name", NAMES)
def test_usual_boxes_are_put_right_and_that_is_told(name: str, unit: float, up: str) -> None:
    file = standing(np.array(category(name).size) / unit, up)
    found = stands(name, tuple(file))
    assert (found.up, found.unit) == (up, unit)
    assert any("up axis" in note for note in found.notes) == (up != "Y")
    assert any("`unit`" in note for note in found.notes) == (unit != 1.0)


def test_what_is_said_stays_but_nonsense_is_told_with_the_remedy() -> None:
    toy = stands("chair", (46.0, 84.0, 53.0), unit=0.001)
    assert (toy.up, toy.unit) == ("Y", 0.001)
    assert "an impossible size for a chair" in toy.notes[0]
    assert "unit: 1 cm" in toy.notes[0]
    lying = stands("wardrobe", (1.2, 0.6, 2.0), up="Y", unit=1.0)
    assert lying.up == "Y"
    assert "`up: Z`" in lying.notes[0]


def test_a_low_chair_is_told() -> None:
    (note,) = stands("chair", (0.4, 0.47, 0.4)).notes
    assert "an impossible size for a chair" in note
    assert "`size`" in note


def test_no_remedy_makes_it_worse() -> None:
    """A board is no box of theirs; a unit by which it were 7 m long would be no help."""
    (*_, note) = stands("box", (0.762, 0.381, 0.0127), up="Z", unit=1.0).notes
    assert "an impossible size for a box" in note
    assert "would make it" not in note


def test_what_rests_on_zero_stands_there() -> None:
    table = posture((-0.4, -0.4, 0.0), (0.4, 0.4, 0.78), Posture("Y", 1.0), usual("table"))
    assert table.up == "Z"


def test_of_a_size_only_the_proportions_count() -> None:
    found = stands("bed", (100.0, 200.0, 50.0), size=(1.0, 2.0, 0.5))
    assert (found.up, found.unit) == ("Z", 1.0)
    assert "unit" not in " ".join(found.notes)


def test_stated_axes_are_believed_longer() -> None:
    assert stands("chair", (0.46, 0.53, 0.84)).up == "Z"
    assert stands("chair", (0.46, 0.53, 0.84), stated=True).up == "Y"


def test_without_a_category_all_is_as_the_format_has_it() -> None:
    assert posture((0, 0, 0), (9, 9, 90), Posture("Y", 1.0), None) == Posture("Y", 1.0)


def test_an_stl_file_is_furniture(tmp_path: Path) -> None:
    size = category("cabinet").size
    trimesh.creation.box(1000.0 * np.array(size)).export(tmp_path / "box.stl")
    model = read_model(tmp_path / "box.stl", usual=usual("cabinet"))
    low, high = model.extent
    assert high - low == pytest.approx(size)
    assert any("1 mm is taken" in note for note in model.notes)
    (mesh,) = model.parts.values()
    assert len(mesh.points) == 8


def test_a_glb_material_without_a_colour_is_grey(tmp_path: Path) -> None:
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    box.visual = trimesh.visual.TextureVisuals(material=trimesh.visual.material.PBRMaterial())
    box.export(tmp_path / "box.glb")
    (surface,) = read_model(tmp_path / "box.glb").surfaces.values()
    red, green, blue = surface.base_color
    assert red == green == blue
    assert surface.metallic == 0.0


@pytest.mark.parametrize("folder", ["images", "textures"])
def test_pictures_in_a_sibling_folder(tmp_path: Path, folder: str) -> None:
    objs = tmp_path / "objs"
    objs.mkdir()
    (objs / "a.obj").write_text(
        "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    )
    for where, picture in ((folder, "a.png"), ("secrets", "b.png")):
        (tmp_path / where).mkdir()
        write_png(tmp_path / where / picture, np.zeros((2, 2, 3), np.uint8))
        (objs / "a.mtl").write_text(f"newmtl m\nmap_Kd ../{where}/{picture}\n")
        model = read_model(objs / "a.obj")
        (surface,) = model.surfaces.values()
        assert isinstance(surface.base_color, tuple) == (where == "secrets")
        assert any("outside" in note for note in model.notes) == (where == "secrets")


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("bed_dalselv_0270", "bed"),
        ("chair_ivar_0668", "chair"),
        ("tvunit_0406", "cabinet"),
        ("shelf_lillagen_0927", "bookshelf"),
        ("table_dockstra_0279", "table"),
    ],
)
def test_models_of_a_program_with_z_up(real: Real, name: str, kind: str) -> None:
    path = real(f"ikea_furniture_parts/assembled/{name}.obj")
    low, high = read_model(path, usual=usual(kind)).extent
    rows = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith("v ")]
    assert high - low == pytest.approx(np.ptp(np.array(rows, dtype=float), axis=0), abs=1e-6)


@pytest.mark.parametrize(
    ("name", "kind", "size"),
    [
        ("chair", "chair", (0.4, 0.42, 0.9)),
        ("desk", "desk", (1.4, 0.678, 0.77)),
        ("cooker", "stove", (0.6, 0.62, 0.85)),
        ("fridgeFreezer", "refrigerator", (0.6, 0.66, 1.85)),
    ],
)
def test_models_of_a_catalogue_in_units_of_its_own(
    real: Real, name: str, kind: str, size: tuple[float, float, float]
) -> None:
    path = real(f"sweethome3d_furniture/resources/{name}.obj")
    low, high = read_model(path, usual=usual(kind)).extent
    assert high - low == pytest.approx(size, rel=0.06)
    toy = read_model(path, usual=usual(kind), unit=0.01)
    assert "an impossible size" in " ".join(toy.notes)
