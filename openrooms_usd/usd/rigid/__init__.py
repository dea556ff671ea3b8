"""Any UsdPhysics stage as bodies, links, joints, shapes and contacts for engines.

- `shapes`: where bodies stand, what collides and what is seen;
- `masses`: what bodies weigh;
- `joints`: what joins them, as trees;
- `reading`: the whole neutral world, and what passes through each other.
"""
