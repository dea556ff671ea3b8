"""The plan of a room, drawn by a person over what was scanned.

In the order of the work: `drawing` is the plan as plain data. `corners` and `fittings` change it,
and `operations` names the requests of a page. `document` reads and writes ``room.yaml``, and
`underlay` is the scan below it. `pictures` shows the points. `session` is the page: it begins and
undoes.
"""
