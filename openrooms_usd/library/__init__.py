"""Furniture, materials and environments: made by rules, published as USD assets.

- furniture: `furniture`, `assets`, `construction`, `timber`, `finishes` (`finish`,
  `small_finishes`);
- styles of rooms: `interior`, `interiors`, `ensembles`, `shellstyles`; their lamps: `lamplight`,
  `beams`; what screens show: `displays`;
- materials: `textures`, `thumbnails`, `assignment`, `friction`, `ownmaterials`;
- surroundings: `solar`, `sunlight`, `skylight`, `sky`, `outside`, `skycache`, `panorama`,
  `environments`, `pictures`;
- models of others: `pieces`, `wavefront`, `gltf`, `usdfile`, `urdf` (with
  `urdftree`, `plainxml`), `posture` (their up axis and unit), `meshfile`, `cads`.
"""
