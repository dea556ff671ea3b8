"""OpenRooms' own scene files.

In: ``importer`` is the story. ``records`` (what a file says) and ``reading`` (of a file that may be
hostile); ``roots`` (where the dataset's files are), ``things`` (what shapes are), ``poses`` and
``viewpoints`` (where everything stands), ``shell`` (the room's plan), ``models`` and ``materials``
(what shows it), ``standins`` (what stands for what is not there), ``scene`` (all of it together).
"""
