"""What a room is made of and lit by, from its photographs.

``driver`` does it all for files. ``photographs`` and ``pictures`` read, ``registration`` checks
poses (``depthfit``, ``linefit``, ``lines``, ``edges``, ``motions``, ``views``). ``observations``
picks pixels with what they see; ``transport`` samples how light reaches it (``straight``,
``elements``, ``directions``, ``places``). ``recovery`` states the ``problem``; ``solving`` finds
colours, lights and cameras (``priors``, ``curve``), ``gloss`` roughness and metals. ``charts`` and
``textures`` make pictures, ``authoring`` writes opinions.
"""
