"""Any UsdPhysics stage as bodies, links, joints, shapes and contacts for engines.

- `frames`: where bodies stand; `masses`: what they weigh; `joints`: what they join, as trees;
- `shapes`: what collides and what is seen;
- `reading`: the whole neutral world, and what passes through each other.
"""
