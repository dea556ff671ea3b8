"""People's own models: meshes, USD and URDF files as parts in our object frame.

Modules: `pieces`, `wavefront`, `gltf`, `usdfile`, `urdf`, `plainxml`, `posture`, `meshfile`,
`cads`.
"""
