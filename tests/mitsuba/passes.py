"""Channels of light by the pass that gives them, where all are asked for."""

# One of each kind of pass, and all that each gives.
PASSES = {
    "light": tuple(
        (
            "radiance emission direct indirect radiance_i diffuse specular irradiance "
            "irradiance_direct irradiance_indirect irradiance_i direct_i unoccluded_i "
            "visibility_i"
        ).split()
    ),
    "environment": ("environment", "environment_direct"),
}
LIT = tuple(name for names in PASSES.values() for name in names)
