"""A composed USD stage as what a renderer receives, and everything that is computed without light.

In the order in which they are needed:

- ``translate`` tells the story: lights, surfaces, labels and a report of every prim become a
  ``Scene`` (``arrays``). It reads lamps and surroundings (``lamps``) and the reflection of surfaces
  (``surfaces``, with ``pictures``, ``codes`` and ``wrapping`` for their textures). It reads the
  material of each mesh (``mesh_surfaces``, with colours of the mesh, ``painted``, and displacement,
  ``displaced``). It assigns objects, parts and classes (``labels``, ``legend``), and reports what
  no picture shows (``unseen``). ``gathering`` makes shapes of what has the same surface: plain
  ``triangles``, and ``instances`` that share theirs. A stage without any light stands in a default
  one.
- ``models`` gives all surfaces one reflectance model where a renderer takes no other; ``cameras``
  says what is lost of the stage's, and ``framing`` makes one for a large scene without any.
- ``sources`` numbers the lights. ``light_records`` describes them (``lights``), openings by the
  ``surroundings`` that they see and a fit of those
  (``window_lobes``); ``lights`` says, too, which lamps count on which surfaces.
- ``rays`` finds the triangle in the centre of each pixel, ``first_hits`` computes where it is met
  in double precision, ``ground_truth`` looks up geometry, material and labels there.

`moving` follows what moves in a scene that is open; `digest` tells by what its light differs from
others'.
"""
