"""The points of a scan, and what can be told of them alone.

- `cloud`: points with colours, normals, labels and sensor origins; `fusion`: of depth frames;
- `thinning`, `voxels`: fewer points that say the same, in a bounded amount of memory;
- `normals`, `planes`, `surfels`: directions, planes in noise, small flat pieces;
- `visibility`, `sightlines`: how far the sensors looked, and what they looked through.
"""
