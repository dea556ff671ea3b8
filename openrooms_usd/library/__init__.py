"""Furniture, materials and environments: made by rules, published as USD assets.

- `models`: people's own models: meshes, USD and URDF files as parts in our object frame;
- `surroundings`: sun, sky, environments, and the world outside;
- `styles`: styles of rooms: finishes, lamps, screens, and which material things are made of;
- besides: `assets`, `construction`, `friction`, `ownmaterials`, `pictures`, `textures`,
  `thumbnails`, `timber`.
"""
