"""Authoring and reading USD by concept; knows no stage of the pipeline and no renderer.

- `files`: files: looked through before USD opens them, stacked, and what is wrong with them;
- `places`: where things are: units, axes, transforms, poses; who stands above whom; free walls;
- `shapes`: surfaces as triangles: the walk over a stage, and the reader of each kind of prim;
- `shading`: materials: authored and read, from UsdPreviewSurface, MaterialX and textures;
- `light`: lights: authored, found and read as plain data, with their profiles;
- besides: `arrays`, `bodies`, `cameras`, `doubts`, `mapping`, `moments`, `outside`,
  `rendersettings`, `rigid`, `semantics`.
"""
