"""Posed photographs in the forms that people have, one module a form.

- `framelist`: our own JSON list; `nerfstudio`: ``transforms.json``; `colmap`: models;
- `sevenscenes`, `tum`, `redwood`, `scannet`, `arkitscenes`, `sunrgbd`: depth cameras;
- `pictures`: names, sizes and intrinsics that several of them share.
"""
