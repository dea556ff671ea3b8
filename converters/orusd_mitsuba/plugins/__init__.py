"""A scene as objects of Mitsuba, and the plugins of our own among them.

- ``build`` makes all of it for the active variant: textures, BSDFs, emitters, and shapes of
  ``meshes``, where instances are kept or expanded.
- ``descriptions`` says what becomes of surfaces and lights, ``sensors`` what becomes of cameras, in
  plugins that XML can name too; ``lenses`` bends the rays of a camera with a lens.
- ``openrooms_bsdf`` is OpenRooms' reflectance model (its formulas in ``microfacet``),
  ``preview_bsdf`` UsdPreviewSurface, and ``material_table`` makes many materials one of either;
  ``two_ways`` is a texture that repeats in one direction alone.
- ``light_weights`` says how often each light is sampled, and ``portal_environment`` samples the
  surroundings where they come in.
- ``shaped_area`` is a lamp that follows a profile, ``sun_disk`` parallel light with soft shadows.
- ``memory`` is where arrays lie, so that kernels do not depend on chance.
"""
