"""Furniture in scans that nobody labelled, without trained weights.

In the order of the work:

- `contents`: what stands in a room, without the room itself;
- `tops`: the horizontal surfaces of furniture, and which of them belong to one piece;
- `grouping`: pieces around tops, and connected parts without one;
- `shape`: the box, seat, back and closed sides of a piece;
- `naming`: a category by shape and size, where the evidence is good;
- `byshape`: our own segmenter, which runs these;
- `boxes`: what stands for pieces without a name, apart from each other;
- `labelled`: clouds with words or classes, but without numbers of things;
- `contract`: what any segmenter does.
"""
