"""How far away pictures are sharp: at their subject, or else at what is in their middle."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.composition import NO_SUBJECT, Subjects
from openrooms_usd.geometry.looks import Look, Views, look_of
from openrooms_usd.geometry.raycast import RayCaster

Array = NDArray[np.float64]

_RESOLUTION: Final = (80, 60)
# The middle of a picture, out of its width and height.
_MIDDLE_SHARE: Final = 0.25
# Less than this of a picture is nobody's subject.
_LEAST_SUBJECT_SHARE: Final = 0.01


def focus_distance(
    caster: RayCaster,
    eye: Array,
    forward: Array,
    fov_degrees: float,
    subjects: Subjects | None = None,
) -> float:
    """Metres along the optical axis to what a photographer would focus on; 0 where nothing is.

    Args:
        caster: The scene.
        eye: (3,) where the camera stands, metres.
        forward: (3,) unit viewing direction.
        fov_degrees: Horizontal field of view.
        subjects: What the scene is photographed for; the middle of the picture where it shows none.
    """
    look = look_of(caster, Views(eye[None], forward[None]), fov_degrees, *_RESOLUTION)
    depth, seen = look.depth[0], look.seen[0]
    rows, columns = (
        slice(round(n * (0.5 - _MIDDLE_SHARE / 2)), round(n * (0.5 + _MIDDLE_SHARE / 2)))
        for n in depth.shape
    )
    middle = np.zeros_like(seen)
    middle[rows, columns] = True
    choices = (_of_subject(subjects, look), middle, seen)
    at = next((seen & choice for choice in choices if (seen & choice).any()), seen)
    return float(np.median(depth[at])) if at.any() else 0.0


def _of_subject(subjects: Subjects | None, look: Look) -> NDArray[np.bool_]:
    """(H, W) where the picture shows the subject that fills most of it, by its weight."""
    if subjects is None or not len(subjects.weights):
        return np.zeros_like(look.seen[0])
    subject = np.where(look.seen[0], subjects.of_triangle[look.triangles[0]], NO_SUBJECT)
    share = np.array([(subject == row).mean() for row in range(len(subjects.weights))])
    worth = np.where(share < _LEAST_SUBJECT_SHARE, 0.0, share * subjects.weights)
    return np.asarray((subject == worth.argmax()) & (worth.max() > 0.0))
