"""Camera paths: walks through a room as ground truth frame by frame, and as a video.

``rendering`` is what commands call: it writes the files. ``choosing`` finds the `CameraPath`
(``camera_path``) that is meant: key frames of a file, a camera of the stage that moves, or an
automatic ``walk`` through ``free_space``; ``spline`` makes them smooth. ``film`` renders frame by
frame: it adds to each what ``reprojection`` finds of earlier ones and measures what still
flickers; ``video`` encodes.
"""
