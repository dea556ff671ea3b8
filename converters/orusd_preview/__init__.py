"""A second renderer: quick pictures by rays that are cast and not followed, for thumbnails.

``adapter`` is what is registered, ``session`` the story of a picture: how it is lit and how much of
the hemisphere is free. All other channels are the core's.
"""

from orusd_preview.adapter import PreviewRenderer

__all__ = ["PreviewRenderer"]
