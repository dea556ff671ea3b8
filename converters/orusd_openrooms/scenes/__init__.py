"""OpenRooms' own scene files, in and out; ``records`` says what such a file holds.

In: ``importer`` is the story. ``reading`` (of untrusted files), ``roots`` (where the dataset's
files are) and ``sceneobjects`` (what shapes are). ``shell`` (the room's plan), ``models`` and
``materials`` (import and export), ``standins`` (replacements for missing files) and ``scene`` (all
of it together).

Out: ``exporter`` is what is registered, ``export`` the story. ``objects`` (what of a stage becomes
a shape), ``layoutfiles`` (the shell's meshes), ``modelfiles`` (the others' and their steps),
``lightboxes`` (the panorama, and what loaders read of lights).
"""
