"""Furniture, materials and environments: made by rules, published as USD assets.

- furniture: `furniture`, `assets`, `construction`, `timber`, `finishes`;
- styles of rooms: `interiors`, `ensembles`; their lamps: `lamplight`, `beams`; what screens show:
  `displays`;
- materials: `textures`, `thumbnails`, `assignment`, `friction`, `ownmaterials`;
- surroundings: `solar`, `sunlight`, `sky`, `outside`, `skycache`, `panorama`, `environments`,
  `pictures`;
- models of others: `pieces`, `wavefront`, `gltf`, `usdfile`, `urdf` (with `plainxml`), `posture`
  (their up axis and unit), `meshfile`, `cads`.
"""
