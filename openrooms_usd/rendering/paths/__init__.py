"""Camera paths: walks through a room as ground truth frame by frame, and as a video.

``rendering`` is what commands call: it writes the files. ``choosing`` finds the `CameraPath`
(``camera_path``) that is meant: ``keyframes`` of a file, a ``timed`` camera of the stage, or an
automatic ``walk`` through ``free_space``; ``spline`` makes them smooth. ``film`` renders frame by
frame: ``accumulation`` adds to each what ``reprojection`` finds of earlier ones, ``steadiness``
measures what still flickers, and ``video`` encodes.
"""
