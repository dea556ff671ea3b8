"""From a raw scan to a room: pure functions of point clouds, without trained weights."""
