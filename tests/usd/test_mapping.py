"""The table of all concepts of USD: whole, by USD's own registries, and as its page shows it."""

from docs.usd_mapping import PAGE, page
from openrooms_usd.usd import mapping

OUTCOMES = {"supported", "approximated", "reported", "ignored"}


def test_every_type_property_and_input_has_a_row_and_every_row_has_one() -> None:
    schemas, shaders = mapping.schemas(), mapping.shader_inputs()
    assert len(schemas) > 100 and {"Mesh", "LightAPI", "Volume"} <= set(schemas)
    assert {"UsdPreviewSurface", "UsdPrimvarReader_float2"} <= set(shaders)
    found = {("types", name): mapping.row_of_type(name) for name in schemas}
    for name, (_, properties) in schemas.items():
        for one in properties:
            row = mapping.row_of_property(mapping.lineage(name), one)
            found["properties", f"{name}.{one}"] = row
    for name, inputs in shaders.items():
        for one in inputs:
            found["shaders", f"{name}.{one}"] = mapping.row_of_input(name, one)
    assert [at for at, row in found.items() if row is None] == []
    used = {(section, row.name) for (section, _), row in found.items() if row is not None}
    known = {(s, name) for s in ("types", "properties", "shaders") for name in mapping.rows(s)}
    assert known - used == set(), "rows that USD knows nothing of"


def test_rows_are_of_one_of_four_kinds_and_say_who_tells() -> None:
    rows = [row for s in ("types", "properties", "shaders") for row in mapping.rows(s).values()]
    assert {row.outcome for row in rows} == OUTCOMES
    assert [row for row in rows if not row.becomes] == []
    assert [row for row in rows if row.told_by and row.outcome != "reported"] == []


def test_what_the_table_alone_tells_of_stands_there_by_its_name() -> None:
    assert [name for name in mapping.told_of() if set("*[") & set(name)] == []


def test_the_nearest_row_counts() -> None:
    def outcome(kind: str, name: str, *applied: str) -> str | None:
        row = mapping.row_of_property(mapping.lineage(kind, applied), name)
        return row and row.outcome

    assert outcome("Mesh", "normals") == "supported"
    assert outcome("TetMesh", "normals") == "reported"
    assert outcome("SphereLight", "inputs:intensity") == "supported"
    assert outcome("GeometryLight", "inputs:intensity") == "reported"
    # What is applied speaks of its own properties alone.
    assert outcome("Cube", "size", "LODRootAPI") == "supported"
    assert outcome("Cube", "lod:heuristics", "LODRootAPI") == "reported"
    assert outcome("Cube", "of_nobody") is None
    assert mapping.row_of_type("OfNobody") is None


def test_the_page_is_fresh() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run: python -m docs.usd_mapping"
