"""Lightmaps: the irradiance of every light on the surfaces of a stage, as textures beside a layer.

In the order of the work: ``units`` are the meshes and instances that get a lightmap; ``atlases``
lays each out and places it in a picture; ``texels`` finds the points of the surfaces that every
texel stands for. Renderers that can
(``request``) estimate the light there. ``pictures`` fills the pictures with it, ``layer`` writes
the layer that refers to them, and ``baking`` tells the story.
"""
