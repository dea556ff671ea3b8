"""Finished renders for radiance fields and photogrammetry: cameras, pictures, depth, points.

``dataset`` is the story: it finds surface points and who sees them. ``cameras`` says where a camera
stands in the words of each tool, and writes ``cameras.json`` and ``cameras.npz``; ``pictures``
makes the images and depth maps.
"""

from orusd_nerf.dataset import NerfDataset

__all__ = ["NerfDataset"]
