"""What is done with simulations: rooms settle, robots drive and see; knows engines by contract.

- `settling`, `settledlayer`: rooms come to rest, watched, and are written;
- `robots`, `driving`, `pushing`, `robot_cameras`: robots; `floors`: friction from looks; `strips`:
  pictures of episodes.
"""
