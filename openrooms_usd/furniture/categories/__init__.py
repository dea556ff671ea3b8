"""What the library builds: one module a category, of its name, with its builders and its record.

A module here is all that a category needs: its name is what descriptions call it, and its record
(``CATEGORY``) says what is special about it. A plain one::

    CATEGORY: Final = BuiltCategory(
        description="a stool for feet",
        size=(0.4, 0.4, 0.25),
        styles={"plain": Style(build)},
        mass_range=(1, 4),
        schemes=(Scheme({ANY: "wood"}),),
    )
"""
