"""Materials: authored and read, from UsdPreviewSurface, MaterialX and textures.

Modules: `surfaces`, `materials`, `materialreader`, `physics`, `networks`, `uvtextures`,
`textures`, `mtlxlayers`, `mtlxversions`, `uber`, `mdl`, `nodegraphs`.
"""
