"""The light cache: what surfaces of a room receive of each light, computed once for all views.

- ``surfels`` are the elements of surface that have a value, found by hashing.
- ``population`` finds points of them where light may come, ``filling`` what arrives there: by
  ``links`` of what lights and other surfels send, from one to the other.
- ``tracing`` follows paths that end where the cache knows what is scattered.
- ``arriving`` looks up what very many rays bring to points, for environment maps.
- ``scattered`` gives them to integrators that find direct light themselves.
- ``room_light`` is the cache of an opened room: filled, or read from its file;
  and the integrator that looks it up.
"""
