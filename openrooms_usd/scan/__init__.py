"""From a raw scan to a room: pure functions of point clouds, without trained weights.

In the order of the work:

- `points`: cleaning, downsampling, normals, plane fits and surfels; visibility from the sensors;
- `rooms`: the level frame, wall hypotheses, and rooms as closed polygons by minimum cuts;
- `openings`: doors, windows and passages in these walls;
- `segmentation`: furniture in scans without labels, and the contract of segmenters;
- `models`: CADs that are fitted to objects;
- `registration`: retrieval of CADs, and robust registration of pose and scale;
- `placement`: the support relation, and penetrations resolved by the least motion;
- `shown`: how much of a room a scan shows;
- `report`: plans and captions for people.

`reconstruction` runs them; `results`, `artefact` says what was found, in the scan's own frame.
"""
