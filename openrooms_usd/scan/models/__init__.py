"""CADs that are fitted to a scan, and meshes of unknown origin.

- `glb`, `meshscene`: foreign meshes, with limits that are checked before a library unpacks them;
- `folder`: a folder of them with its index; `cad`: one with points on its surface.
"""
