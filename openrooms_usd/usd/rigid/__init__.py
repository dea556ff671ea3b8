"""Any UsdPhysics stage as bodies, links, joints, shapes and contacts for engines.

- `shapes`: where bodies stand, what collides and what is seen;
- `joints`: what bodies weigh, and what joins them, as trees;
- `reading`: the whole neutral world, and what passes through each other.
"""
