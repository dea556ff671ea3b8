"""A stage as one GLB file (glTF 2.0), for the web, game engines and viewers.

Importing this package imports neither USD nor a codec. In the order of the work:

- ``exporter`` is registered as entry point; ``options`` says what may be asked of it, ``scene``
  tells the story;
- ``hierarchy`` places prims as nodes, and joins nodes of one mesh where that is asked for;
- ``geometry`` makes vertices of triangles;
- ``looks`` reads what the parts of meshes are made of;
- ``materials`` turns surfaces into metallic-roughness, ``pictures`` packs their textures;
- ``lamps`` and ``cameras`` do what their names say;
- ``baked`` multiplies colours and lightmaps, ``unlit`` shows them without any lamp;
- ``draco`` packs vertices, where that is asked for;
- ``document`` gathers the JSON objects and the binary buffer, and writes the file.
"""

from orusd_gltf.exporter import GltfExporter

__all__ = ["GltfExporter"]
