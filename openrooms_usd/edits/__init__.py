"""What people change in a composed room: what is lost, and how it is kept.

- `editing`: changes made in Python, and taken back; `orphans`: those that find their prim no more;
- `assigning`, `arranging`, `remaking`: such changes of materials, places and models, and new things
  (`targets`: what is meant, `snapping`: where it comes to stand);
- `scenefile`, `views`, `objects`: what any scene holds, for Python: cameras, lights,
  materials, and objects that make these changes;
- `foreign`, `flattened`, `merging`, `adopting`: what another program saved over the scene;
- `blender`, `blender_changes`: which object is which prim, what was done, what is new;
  `fitting`: other units and axes.
"""
