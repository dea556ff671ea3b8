"""Any UsdPhysics stage as bodies, links, joints, shapes and contacts for engines.

- `shapes`: where bodies stand, what collides and what is seen;
- `masses`: what bodies weigh;
- `joints`: the directions that joints leave free, and what drives them;
- `trees`: what joints make of links, and where they close loops;
- `filters`: what passes through each other;
- `reading`: the whole neutral world.
"""
