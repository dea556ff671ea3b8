"""Light that is followed along paths: what arrives at a camera, or at points, by light and kind.

- ``path_tracing`` follows paths and adds up what they bring, by the lights of ``light_index``.
- ``panes`` is what clear panes do to light on its way.
- ``scattered`` is the contract for what surfaces scatter back along rays, and its reference: the
  rest of a path.
- ``paths`` is how they are requested, whichever integrator follows them.
- ``lattice`` spreads the first random numbers of a pixel's samples, ``white`` makes the first
  surface white, for irradiance.
- ``integrator`` estimates a camera's pictures, a batch at a time: ``path_integrator`` by our paths
in ``bands`` of rows, ``builtin_integrator`` by Mitsuba's. ``hemispheres`` and ``probes`` use
``incident``, the radiance that arrives at points by direction, in ``cells``, found as in
``arrival``. ``texels`` are those of lightmaps. - ``sampling`` goes on with batches until a request
is met, in ``strips`` of rows, so that memory is bounded.
"""
