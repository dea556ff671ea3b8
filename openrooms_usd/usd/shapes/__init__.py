"""Surfaces as triangles: the walk over a stage, and the reader of each kind of prim.

Modules: `traversal`, `gprims`, `tessellation`, `subdivided`, `curves`, `patches`, `meshes`.
"""
