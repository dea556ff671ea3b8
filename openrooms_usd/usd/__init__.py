"""Authoring and reading USD by concept; knows no stage of the pipeline and no renderer.

`mapping` says what becomes of each concept in a picture.

- opening: `crates`, `crate_reader`, `preflight`, `diagnostics`; `layers`, `activation`, `outside`;
- time: `moments`, `skinning`;
- places: `frames`, `metrics`, `transforms`, `placements`, `partitions`, `settled`;
- surfaces: `traversal`, `gprims`, `arrays`, `tessellation`, `subdivided`, `creases`,
  `curves`, `patches` (both give a `drawn`), `meshes`;
- materials: `surfaces`, `materials`, `materialreader`, `bindings`, `physics`; of their networks
  `networks`, `uvtextures`, `textures`, `udim`;
  of MaterialX `mtlxlayers`, `uber`, `nodegraphs`, `nodecoordinates`;
- light: `photometry`, `emitters`, `lightreader`, `lightsearch`, `shaping` (with IES `profiles`,
  `cones`), `lights`, `linking`, `portals`; `cameras`, `fields_of_view`, `rendersettings`;
- meaning: `taxonomies`, `semantics`; bodies: `bodies`, `joints`, `rigid`.
"""
