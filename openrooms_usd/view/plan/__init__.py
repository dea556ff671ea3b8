"""The plan of a room, drawn by a person over what was scanned.

In the order of the work: `drawing` is the plan as plain data; `corners` and `fittings` change it,
`operations` names what a page may ask for; `document` reads and writes ``room.yaml``, and what was
scanned under it is `underlay`; `pictures` shows the points; `session` is the page: it begins and
undoes.
"""
