"""Views of finished datasets for training: arrays by channel, each with its camera.

``sample`` is one view as arrays; its cameras stay right whatever is done to it: ``cropping``,
``resizing``, ``mirroring`` and ``toning`` are the transforms, ``transforms`` their contract and
their chains. ``source`` says where views come from, as a contract; ``opening`` finds the one for a
folder or a URL; ``folder`` reads renders and datasets as they were written, ``files`` fetches what
lies elsewhere into a bounded cache. None of these needs torch; ``tensors`` makes batches of samples
and ``training`` loads them.
"""
