"""A room in the browser: pages that show it, and tools with which people change it.

``app`` says what a page is told, may ask for and may do. ``server`` serves it on this machine, and
tells it what other programs changed; ``shell`` makes one file of it. ``room`` is the page of a
stage, and ``prims`` and ``light`` are what it tells of it, at one or several ``moments``;
``tracing`` makes path-traced pictures beside it; ``shots`` are renders and photographs of its
cameras, ``scanned`` the points of a scan; ``plan`` is that of a room's plan, ``materials`` and
``objects`` are those of its things: their ``corrections`` go to ``targets``, which are edits or the
``fields`` of a room.yaml (``describing``), of a scan its hints. Server and file put the same HTML
around a page (``shell``). What runs in the browser lies in ``page/``: modules without a build step,
which ask nobody else for anything. Pages write ``edits.usda`` or fields of ``room.yaml``, nothing
else.
"""
