"""What ``import openrooms_usd`` offers: each function is a door to the core.

``rooms`` (new, generate, load, import) gives a ``room``, which is built step by step. ``scenes``
(compose, open, simulate, convert) makes a ``scene`` with its objects of it. A scene gives
``renders`` (pictures, which ``rendered`` reads as arrays), ``films``, ``light`` (relight, probe),
``appearing`` (materials and lights from photographs) and ``robots``. ``datasets`` are many rooms at
once. ``given`` accepts paths and rooms in every supported form. Importing these modules loads
nothing heavy: what a function needs it imports when it is called.
"""
