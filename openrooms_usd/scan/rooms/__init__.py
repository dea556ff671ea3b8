"""The rooms of a scan: closed polygons with a height.

In the order of the work:

- `ground`, `levelling`, `directions`: gravity, the floor, the directions of walls;
- `ceilings`: their heights and slopes; `doorleaves`: open doors, which are no walls;
- `walls`, `candidates`: evidence of walls and the lines that they lie on;
- `planmap`, `spaces`: what lies in each pixel of the plan, cut into rooms at narrow places;
- `cells`, `costs`, `outline`: a minimum cut of an arrangement of lines, made plain;
- `borders`, `piers`, `refit`, `shown`: ends of partial scans, piers, fitted lines, what was seen;
- `roomcut`: one room; `layout`: all of them.
"""
