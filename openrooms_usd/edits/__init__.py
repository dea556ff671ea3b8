"""What people change in a composed room: what is lost, and how it is kept.

- `editing`: changes made in Python; `orphans`: those that find their prim no more;
- `assigning`, `arranging`, `remaking`: such changes of materials, places and models (`targets`:
  what is meant, `snapping`: where it comes to stand); `history` takes them back;
- `foreign`, `flattened`, `merging`, `adopting`: what another program saved over the scene;
- `blender`, `blender_changes`, `blender_objects`: which object is which prim, what was done, what
  is new; `fitting`: other units and axes.
"""
