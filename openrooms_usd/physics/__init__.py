"""Rigid bodies as arrays: masses, collision shapes, contacts; knows no USD and no engine.

- `borders`, `components`, `enclosure`, `solid`, `surfaces`: what a mesh fills, and distances to it;
- `inertia`, `mass`: what it weighs;
- `hulls`, `cutting`, `merging`, `panels`, `collision_error`: pieces, and their bound of error;
- `convex_decomposition`, `decomposition`: the search for few of them;
- `pair`, `world`: friction of two, and bodies, links, joints and contacts for engines.
"""
