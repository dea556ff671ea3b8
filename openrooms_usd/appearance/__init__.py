"""The materials and lights of a room, from photographs of it."""
