"""Views of finished datasets for training: arrays by channel, each with its camera.

``sample`` is one view as arrays; its cameras stay right whatever is done to it by
``transforms`` and ``resizing``. ``source`` is the contract of sources of views, and ``opening``
finds the one for a folder or a URL. ``folder`` reads renders and datasets as they were written,
``shards`` tar files of them, both by ``rendered``. ``files`` fetches remote files into a bounded
cache. None of these needs torch; ``tensors`` makes batches of samples, ``epochs`` says in which
order, ``training`` loads them by number and ``streaming`` from shards.

The names for people are offered here, and loaded on first use (docs/howto/loading.md).
"""

from typing import TYPE_CHECKING, Final

from openrooms_usd.lazy import loader as _loader

if TYPE_CHECKING:
    from openrooms_usd.loading.opening import open_source as open_source
    from openrooms_usd.loading.resizing import Resize as Resize
    from openrooms_usd.loading.sample import Sample as Sample
    from openrooms_usd.loading.streaming import ViewStream as ViewStream
    from openrooms_usd.loading.tensors import collate as collate
    from openrooms_usd.loading.tensors import tensors_of as tensors_of
    from openrooms_usd.loading.training import ViewDataset as ViewDataset
    from openrooms_usd.loading.training import begin_worker as begin_worker
    from openrooms_usd.loading.training import loader as loader
    from openrooms_usd.loading.transforms import CentreCrop as CentreCrop
    from openrooms_usd.loading.transforms import Compose as Compose
    from openrooms_usd.loading.transforms import Crop as Crop
    from openrooms_usd.loading.transforms import Exposure as Exposure
    from openrooms_usd.loading.transforms import HorizontalFlip as HorizontalFlip
    from openrooms_usd.loading.transforms import Normalise as Normalise
    from openrooms_usd.loading.transforms import QuarterTurn as QuarterTurn
    from openrooms_usd.loading.transforms import RandomCrop as RandomCrop

_HOME: Final = {
    "CentreCrop": "openrooms_usd.loading.transforms",
    "Compose": "openrooms_usd.loading.transforms",
    "Crop": "openrooms_usd.loading.transforms",
    "Exposure": "openrooms_usd.loading.transforms",
    "HorizontalFlip": "openrooms_usd.loading.transforms",
    "Normalise": "openrooms_usd.loading.transforms",
    "QuarterTurn": "openrooms_usd.loading.transforms",
    "RandomCrop": "openrooms_usd.loading.transforms",
    "Resize": "openrooms_usd.loading.resizing",
    "Sample": "openrooms_usd.loading.sample",
    "ViewDataset": "openrooms_usd.loading.training",
    "ViewStream": "openrooms_usd.loading.streaming",
    "begin_worker": "openrooms_usd.loading.training",
    "collate": "openrooms_usd.loading.tensors",
    "loader": "openrooms_usd.loading.training",
    "open_source": "openrooms_usd.loading.opening",
    "tensors_of": "openrooms_usd.loading.tensors",
}

if not TYPE_CHECKING:  # To type checkers there is nothing but the names above.
    __getattr__ = _loader(__name__, _HOME)
