"""WebDataset shards: plain tar files of views, which training reads from end to end.

``dataset`` cuts the views of all rooms into shards, says what a view holds, and writes tar files
that are the same for the same content.
"""

from orusd_webdataset.dataset import WebDataset

__all__ = ["WebDataset"]
