"""A room in the browser: pages that show it, and tools with which people change it.

``app`` defines the state, the requests and the commands of a page. ``server`` serves it on this
machine, and tells it what other programs changed; ``shell`` makes one file of it. ``room`` is the
page of a stage, with ``prims`` and ``light``, at one or several ``moments``. ``tracing`` adds
path-traced pictures, ``shots`` renders and photographs of its cameras, and ``scanned`` the points
of a scan. ``plan`` is the page of a room's plan, ``materials`` and ``objects`` those of its things.
Their ``corrections`` go to ``targets``: edits, or the ``fields`` of a room.yaml (``describing``),
for scans its hints. Server and file put the same HTML around a page (``shell``). What runs in the
browser lies in ``page/``: modules without a build step, which load nothing from other servers.
Pages write ``edits.usda`` or fields of ``room.yaml``, nothing else.
"""
