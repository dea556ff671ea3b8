"""OpenRooms' own scene files, in and out; ``records`` says what such a file holds.

In: ``importer`` is the story. ``reading`` (of a file that may be hostile), ``roots`` (where the
dataset's files are), ``sceneobjects`` (what shapes are), ``shell`` (the room's plan), ``models``
and ``materials`` (what shows it, in and out), ``standins`` (what stands for what is not there),
``scene`` (all of it together).

Out: ``exporter`` is what is registered, ``export`` the story. ``objects`` (what of a stage becomes
a shape), ``layoutfiles`` (the shell's meshes), ``modelfiles`` (the others' and their steps),
``lightboxes`` (the panorama, and what loaders read of lights).
"""
