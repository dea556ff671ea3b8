"""Authoring and reading USD by concept; knows no stage of the pipeline and no renderer.

`mapping` says what becomes of each concept in a picture.

- opening: `crate_reader`, `preflight`, `diagnostics`; `layers`, `activation`, `outside`;
- time: `moments`;
- places: `frames`, `metrics`, `placements`, `partitions`, `settled`;
- surfaces: `traversal`, `gprims`, `arrays`, `tessellation`, `subdivided`,
  `curves`, `patches`, `meshes`;
- materials: `surfaces`, `materials`, `materialreader`, `bindings`, `physics`; of their networks
  `networks`, `uvtextures`, `textures`, `udim`;
  of MaterialX `mtlxlayers`, `uber`, `nodegraphs`, `nodecoordinates`;
- light: `photometry`, `emitters`, `lightreader`, `lightsearch`, `shaping` (with IES `profiles`),
  `lights`; `cameras`, `rendersettings`;
- meaning: `taxonomies`, `semantics`; bodies: `bodies`, `rigid`.
"""
