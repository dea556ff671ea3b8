"""The rooms of a scan: closed polygons with a height.

In the order of the work:

- `verticals`: what speaks for every axis that may be up, in a scan of any unit;
- `levelling`, `directions`: gravity, the floor, the directions of walls;
- `storeys`: floors above each other, and how to separate them;
- `ceilings`: their heights and slopes, and where they are lower;
- `faces`: soffits and wardrobes, which must not become walls;
- `walls`, `candidates`: surfels of walls, and line hypotheses for them and for missed walls;
- `spaces`: occupancy and free space of the plan, what of it ceilings cover, and a
  watershed into rooms;
- `cells`, `outline`: minimum cut of a line arrangement, simplification by cost;
- `roomoutline`: one room with its piers, by robust line fits; `layout`: all of them, without the
  leaves of open doors;
  `flat`: several as one, with walls between.
"""
