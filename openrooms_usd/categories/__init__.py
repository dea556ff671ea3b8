"""What each word for a thing means: one record a category, from which all tables derive.

In the order in which a record is made: `schemes` (which finishes its parts have), `makes` (how they
are made inside), `record` (all that is said of a category), `others` (the records of what nothing
builds), `registry` (the record of a category), `words` (what the words of captures mean). What the
library builds has its record beside its builder, in ``library/furniture``; the names that a
description may use stand in ``description/categories.py``.
"""
