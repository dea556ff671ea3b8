"""The report of a dataset: one HTML page that needs nothing but a browser.

``page`` puts it together and writes it. ``sections`` says what the views show, how well they were
made and what that took, in tables and charts (``blocks``); ``charts`` draws these, ``wording``
words the numbers for people. ``contact`` chooses views that stand for the rest and makes small
pictures of them. How it looks is in ``page.html`` and ``page.css``.
"""
