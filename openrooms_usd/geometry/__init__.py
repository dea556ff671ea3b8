"""Pure arrays in, arrays out: knows no USD and no renderer.

- `vectors`, `rows`, `rotations`, `quaternions`: the basics; `mesh`, `topology`, `normals`,
  `triangulation`, `cages`, `subdivision`, `smooth_normals`, `raycast`: meshes; `uv`,
  `uvquality`, `unwrap`, `shelves`, `grain`: texture coordinates;
- `splines`, `strands`: curves of any kind as polygons;
- `curves`, `polygons`, `joining`, `floorplan`, `pinhole`, `sights`, `looks`, `views`,
  `viewpoints`, `composition`, `focus`, `framing`: the plan, and cameras in it;
- `faces`, `sweeps`, `lofts`, `solids`: building blocks; `walls`, `partitions`,
  `openings`, `shell`, `leaves`, `doors`, `windows`, `hallways`: a room of them;
  `wallruns`, `mouldings`, `panelling`, `claddings`, `ceilings`: what it wears;
- `hemisphere`, `spherical_harmonics`: light by direction; `lobe_pursuit`, `lobe_refinement`,
  `spherical_gaussians`: the same as a sum of lobes.
"""
