"""A stage as one GLB file (glTF 2.0), for the web, game engines and viewers.

Importing this package imports neither USD nor a codec. In the order of the work:

- ``exporter`` is registered as entry point; ``options`` says what may be asked of it, ``scene``
  tells the story;
- ``hierarchy`` places prims as nodes, and joins nodes of one mesh where that is asked for;
- ``geometry`` makes vertices of triangles;
- ``materials`` reads what the parts of meshes are made of, and turns it into metallic-roughness;
  ``pictures`` packs their textures;
- ``lamps`` has lamps and cameras;
- ``baked`` multiplies colours and lightmaps, ``unlit`` shows them without any lamp;
- ``document`` gathers the JSON objects and the binary buffer, packs vertices where that is asked
  for, and writes the file.
"""

from orusd_gltf.exporter import GltfExporter

__all__ = ["GltfExporter"]
