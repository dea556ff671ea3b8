"""Point clouds, and what follows from the points alone.

- `cloud`: points with colours, normals, labels and sensor origins; `fusion`: of depth frames,
  with estimated normals;
- `thinning`, `voxels`: voxel-grid downsampling, and accumulation in bounded memory;
- `planindex`: points above a rectangle of the plan;
- `mainpart`: the place where most of a scan is, without what was seen far outside;
- `surfels`: MSAC plane fits, those from moments, and one surfel a voxel, of sparse scans from the
  nearest points;
- `visibility`, `sightlines`: range panoramas of the sensors, and unoccluded lines of sight.
"""
