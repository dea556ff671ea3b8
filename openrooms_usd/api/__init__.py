"""What ``import openrooms_usd`` offers: each function is a door to the core.

``rooms`` (generate, load, save, import) leads to ``scenes`` (compose, open, edit, simulate,
convert), and these to ``renders`` (pictures, which ``rendered`` reads as arrays), ``films``,
``light`` (relight, probe) and ``robots``; ``datasets`` are many rooms at once; ``given`` takes
paths and rooms in all the ways in which people give them. Importing these modules loads nothing
heavy: what a function needs it imports when it is called.
"""
