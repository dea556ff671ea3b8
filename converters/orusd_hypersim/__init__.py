"""Hypersim's layout: HDF5 pictures of each frame, camera files, and tables of all scenes.

``dataset`` writes the scenes, ``frames`` says what a frame is made of, ``cameras`` has their
conventions, and ``tables`` the CSV files; ``hdf5`` writes files that are the same for the same
content. ``loading`` reads scenes for training.
"""

from orusd_hypersim.dataset import HypersimDataset

__all__ = ["HypersimDataset"]
