"""From a raw scan to a room: pure functions of point clouds, without trained weights.

In the order of the work:

- `points`: a cloud is cleaned, thinned, given normals and surfels; what the sensors saw;
- `rooms`: levelled, its walls found, cut into rooms: closed polygons;
- `openings`: doors, windows and passages in these walls;
- `models`: CADs that may stand for what was scanned;
- `registration`: which CAD, where, how turned, how large;
- `placement`: upright, supported, apart, inside the room;
- `report`: plans and captions for people.

`reconstruction` runs them; `results` says what was found, in the scan's own frame.
"""
