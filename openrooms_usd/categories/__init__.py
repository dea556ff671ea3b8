"""What each word for a thing means: one record a category, from which all tables derive.

In the order in which a record is read: `record` (what is said of every category), `schemes` (which
finishes its parts have), `makes` (how its parts are made inside), `others` (what nothing builds),
`registry` (the record of a word). What the library builds has its record beside its builder, in
``library/furniture``; the names that a description may use are ``description/categories.py``.
"""
