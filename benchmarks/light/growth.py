"""Seconds of a million paths, with the number of lights, pixels and triangles."""

from benchmarks.light.hard import many
from benchmarks.light.radiance import paced
from benchmarks.light.rooms import REFERENCE_SEED, ROOMS, Room, boxes, mean_of
from benchmarks.light.section import Section, Setting, section


def growth(setting: Setting) -> Section:
    """Seconds of a million paths."""
    size = (32, 24) if setting.quick else (96, 72)
    numbers, wide, full = (
        ((1, 5), (1,), (10,)) if setting.quick else ((1, 10, 50), (1, 2, 4), (10, 100, 1000))
    )
    lamps = [("lights", n, Room(many(n), *size)) for n in numbers]
    plain = ROOMS["plain"].build(setting.folder)
    areas = [("pixels", n * n * size[0] * size[1], Room(plain, n * size[0], n * size[1]))
             for n in wide]  # fmt: skip
    solids = [("triangles", 12 * n, Room(boxes(n), *size)) for n in full]
    rows = []
    for what, count, room in (*lamps, *areas, *solids):
        samples = 4 if setting.quick else 16
        reference = mean_of(room.ours, 8 * samples, REFERENCE_SEED)
        ((_, seconds, error, robust),) = paced(room.ours, (samples,), reference, 2)
        paths = samples * room.size[0] * room.size[1] / 1e6
        rows.append({"grows": what, "count": count, "seconds for 1e6 paths": seconds / paths,
                     "relative MSE": error, "robust error": robust})  # fmt: skip
    return section(rows)
