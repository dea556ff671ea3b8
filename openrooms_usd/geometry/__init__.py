"""Pure arrays in, arrays out: knows no USD and no renderer.

- `vectors`, `rotations`, `quaternions`: the basics; `mesh`, `topology`, `normals`,
  `triangulation`, `cages`, `subdivision`, `raycast`: meshes; `uv`, `uvquality`, `unwrap`:
  texture coordinates;
- `splines`, `strands`: curves of any kind as polygons;
- `curves`, `polygons`, `joining`, `floorplan`, `slopes`, `pinhole`, `looks`, `views`, `viewpoints`,
  `composition`, `framing`: the plan, and cameras in it;
- `faces`, `sweeps`, `lofts`, `solids`: building blocks;
- `hemisphere`, `spherical_harmonics`: light by direction; `lobe_pursuit`, `lobe_refinement`,
  `spherical_gaussians`: the same as a sum of lobes.
"""
