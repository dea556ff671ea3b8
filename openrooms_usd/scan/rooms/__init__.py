"""The rooms of a scan: closed polygons with a height.

In the order of the work:

- `verticals`: what speaks for every axis that may be up, in a scan of any unit;
- `ground`, `levelling`, `directions`: gravity, the floor, the directions of walls;
- `storeys`: floors above each other, which are told apart;
- `ceilings`: their heights and slopes; `soffits`: where they are lower;
- `doorleaves`, `faces`: open doors, soffits and wardrobes, which are no walls;
- `walls`, `candidates`: surfels of walls, and line hypotheses for them;
- `occupancy`, `roofs`, `spaces`: occupancy and free space of the plan, what of it ceilings cover,
  a watershed into rooms;
- `cells`, `costs`, `outline`: minimum cut of a line arrangement, simplification by cost;
- `borders`, `piers`, `refit`: walls that a scan missed, piers, robust line fits;
- `coverage`: how much of each wall was scanned, and its residuals;
- `roomoutline`: one room; `layout`: all of them; `flat`: several as one, with walls between.
"""
