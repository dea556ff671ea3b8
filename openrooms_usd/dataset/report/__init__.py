"""The report of a dataset: one HTML page that needs nothing but a browser.

``page`` puts it together and writes it, with small pictures of views that stand for the rest.
``sections`` says what the views show, how well they were made and what that took, in tables and
charts; ``charts`` draws these and words the numbers for people. How it looks is
in ``page.html`` and ``page.css``.
"""
