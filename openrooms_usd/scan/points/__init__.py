"""Point clouds, and what follows from the points alone.

- `cloud`: points with colours, normals, labels and sensor origins; `fusion`: of depth frames;
- `thinning`, `voxels`: voxel-grid downsampling, and accumulation in bounded memory;
- `normals`, `planes`, `surfels`: estimated normals, MSAC plane fits, one surfel a voxel;
- `nearest`, `principal`: plane fits to the nearest points of sparse scans, and from moments;
- `visibility`, `sightlines`: range panoramas of the sensors, and unoccluded lines of sight.
"""
