"""Channels of light by the pass that gives them."""

# One of each kind of pass, and all that each gives.
PASSES = {
    "radiance": ("radiance", "emission", "direct", "indirect", "radiance_i"),
    "irradiance": ("irradiance", "irradiance_direct", "irradiance_indirect", "irradiance_i"),
    "direct light": ("direct_i", "unoccluded_i", "visibility_i"),
    "environment": ("environment", "environment_direct"),
}
LIT = tuple(name for names in PASSES.values() for name in names)
