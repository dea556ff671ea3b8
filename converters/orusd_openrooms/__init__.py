"""OpenRooms' own files, made of finished renders and read back.

``dataset`` is the story of a conversion. What writes: ``layout`` (where every file lies), ``frame``
(a view on its way), ``framefiles`` and ``lightfiles`` (tables of what each file is made of),
``scenefolder`` (what all views of a scene share),
``cameras``, ``lights``, ``unoccluded`` and ``depthshadows``, and the forms ``rgbe``, ``images``,
``binary``, ``environments``, ``fits`` and ``pickles``. What reads is ``readers``; it shares no code
with the writers, and opens pickles by the core's ``unpickling``; ``loading`` offers what it reads
as views for training, which ``listing`` finds.

``scenes`` reads the release's scene files as an importer, and writes them as an exporter.

``crowding`` finds views with more lights than loaders have room for, ``cautions`` says what else
may hinder them. ``records`` reads what a manifest says of lights, ``resampling`` brings pictures to
other sizes.
"""

from orusd_openrooms.dataset import OpenRoomsDataset

__all__ = ["OpenRoomsDataset"]
