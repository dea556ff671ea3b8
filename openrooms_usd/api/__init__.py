"""What ``import openrooms_usd`` offers: each function is a door to the core.

``rooms`` (new, generate, load, import) gives a ``room``, which is built step by step and leads by
``scenes`` (compose, open, simulate, convert) to a ``scene`` with its objects, and these to
``renders`` (pictures, which ``rendered`` reads as arrays), ``films``, ``light`` (relight, probe)
and ``robots``; ``datasets`` are many rooms at once; ``given`` takes paths and rooms in all the ways
in which people give them. Importing these modules loads nothing heavy: what a function needs it
imports when it is called.
"""
