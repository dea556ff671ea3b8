"""Furniture in scans without labels, without trained weights.

In the order of the work:

- `grouping`: the horizontal surfaces of furniture, pieces around them, and connected parts without
  one;
- `shape`: the box, seat, back and closed sides of a piece;
- `naming`: a category by shape and size, where the evidence is good, or by words and classes of
  points that have no numbers of things;
- `byshape`: our own segmenter: what stands in a room, by all of these;
- `boxes`: what stands for pieces without a name, apart from each other;
- `contract`: what any segmenter does.
"""
