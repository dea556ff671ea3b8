"""Furniture, materials and environments: made by rules, published as USD assets.

- furniture: `furniture`, `assets`, `construction`, `timber`, `finishes`;
- styles of rooms: `interiors`, `ensembles`; their lamps: `beams`; what screens show:
  `displays`;
- materials: `textures`, `thumbnails`, `assignment`, `friction`, `ownmaterials`;
- surroundings: `sunlight`, `sky`, `outside`, `skycache`, `environments`, `pictures`;
- models of others: `pieces`, `wavefront`, `gltf`, `usdfile`, `urdf` (with `plainxml`), `posture`
  (their up axis and unit), `meshfile`, `cads`.
"""
