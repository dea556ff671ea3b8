"""OpenRooms' own files, made of finished renders and read back.

``dataset`` is the story of a conversion. What writes: ``layout`` (where every file lies), ``frame``
(a view on its way), ``framefiles`` and ``lightfiles`` (tables of what each file is made of),
``cameras``, ``lights``, and the forms ``images`` and ``pickles``. What
reads is ``readers``; it shares no code with the writers, and opens pickles by the core's
``unpickling``; ``loading`` offers what it reads as views for training.

``scenes`` reads the release's scene files as an importer, and writes them as an exporter.

``crowding`` finds views with more lights than loaders have room for. ``lights`` reads
what a manifest says of them.
"""

from orusd_openrooms.dataset import OpenRoomsDataset

__all__ = ["OpenRoomsDataset"]
