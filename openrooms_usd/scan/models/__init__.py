"""CADs that are fitted to a scan, and meshes of unknown origin.

- `meshscene`: foreign meshes, with limits that are checked before a library unpacks them;
- `glbarrays`: the arrays of a GLB file, as every reader knows them;
- `objtext`: what programs write as OBJ, as the format has it;
- `cad`: one with points on its surface, and its symmetry about its vertical.
"""
