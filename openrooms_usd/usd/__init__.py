"""Authoring and reading USD by concept; knows no stage of the pipeline and no renderer.

`mapping` says what becomes of each concept in a picture.

- opening: `crate_reader`, `preflight`, `diagnostics`; `layers`, `outside`;
- time: `moments`;
- places: `frames`, `metrics`, `placements`, `partitions`, `settled`;
- surfaces: `traversal`, `gprims`, `arrays`, `tessellation`, `subdivided`,
  `curves`, `patches`, `meshes`;
- materials: `surfaces`, `materials`, `materialreader`, `physics`; of their networks
  `networks`, `uvtextures`, `textures`, `udim`;
  of MaterialX `mtlxlayers`, `uber`, `nodegraphs`, `nodecoordinates`;
- light: `emitters`, `lightreader`, `lightsearch`, `shaping` (with IES `profiles`),
  `lights`; `cameras`, `rendersettings`;
- meaning: `semantics`; bodies: `bodies`, `rigid`.
"""
