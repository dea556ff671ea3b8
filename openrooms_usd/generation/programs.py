"""What each kind of room is like: its size, its shape, its openings and what stands in it.

Groups are tried in the order of the table, so that what a room is for finds its place first.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from openrooms_usd.generation.groups import kitchen, sitting, sleeping, storing, wet, working
from openrooms_usd.generation.items import Group
from openrooms_usd.generation.kit import Kit

_MIXED: Final[dict[str, float]] = {
    "rectangle": 5,
    "L": 2,
    "T": 0.6,
    "U": 0.4,
    "chamfer": 1,
    "slant": 1,
}
_PLAIN: Final[dict[str, float]] = {"rectangle": 6, "L": 1, "chamfer": 0.5, "slant": 0.5}


@dataclass(frozen=True)
class Spec:
    """A group that a room may have.

    Attributes:
        build: Makes it.
        least: How many are needed: a room without them is drawn again.
        most: How many there may be.
        each: One for this much floor, square metres; any number up to the most by default.
        chance: How often the room wants any.
        faces: The title of a group that it shall look at.
        unless: The title of a group beside which the room wants none.
    """

    build: Callable[[Kit], Group | None]
    least: int = 0
    most: int = 1
    each: float = 0.0
    chance: float = 1.0
    faces: str = ""
    unless: str = ""


@dataclass(frozen=True)
class RoomProgram:
    """A kind of room.

    Attributes:
        area: Least, usual and greatest floor area, square metres.
        wants: What stands in it, the most important first.
        shapes: How often its plan is of each shape.
        aspect: Range of its longer side over its shorter one.
        height: Range of its height, metres.
        doors: Range of the number of doors.
        windows: Range of the number of windows.
        high_windows: Whether they are small and high up.
        sills: How high usual windows begin, metres: in kitchens above the worktop.
        glazed: How often its windows reach down to the floor.
        swing_out: How often its doors open outwards.
        gate: How often it has a wide opening.
        hangs: What hangs on its walls: category, least and greatest number.
        curtains: How often its windows have curtains.
        lux: Range of the mean illuminance that its lamps are chosen for.
    """

    area: tuple[float, float, float]
    wants: tuple[Spec, ...]
    shapes: dict[str, float] = field(default_factory=lambda: dict(_MIXED))
    aspect: tuple[float, float] = (1.0, 1.6)
    height: tuple[float, float] = (2.45, 2.8)
    doors: tuple[int, int] = (1, 2)
    windows: tuple[int, int] = (1, 3)
    high_windows: bool = False
    sills: tuple[float, ...] = (0.8, 0.85, 0.9, 1.0)
    glazed: float = 0.1
    swing_out: float = 0.15
    gate: float = 0.0
    hangs: tuple[tuple[str, int, int], ...] = (("picture", 0, 3), ("clock", 0, 1))
    curtains: float = 0.0
    lux: tuple[float, float] = (120.0, 250.0)


_WORK: Final = (("whiteboard", 0, 1), ("wall_shelf", 0, 1), ("clock", 0, 1), ("picture", 1, 3))
_CLASS: Final = (("clock", 1, 1), ("picture", 1, 3), ("whiteboard", 0, 1))
_BARE: Final = (("clock", 0, 1), ("picture", 0, 1))


def _of(build: Callable[..., Group | None], *args: Any, **kwargs: Any) -> Callable[[Kit], Any]:
    return partial(_late, build, args, kwargs)


def _late(build: Callable[..., Any], args: Any, kwargs: Any, kit: Kit) -> Any:
    return build(kit, *args, **kwargs)


def _piece(name: str, **kwargs: Any) -> Callable[[Kit], Any]:
    return _of(storing.piece, name, **kwargs)


def _thing(name: str) -> Callable[[Kit], Any]:
    return _of(storing.thing, name)


def _shoe_rack(kit: Kit) -> Group:
    size = kit.size("rack", kit.between(0.6, 0.9), style="shoe")
    item = kit.item("rack", size=size, style="shoe")
    return Group("besides", (item,), back=0.5 * size[1])


PIANO = Spec(_piece("piano", before=0.9, tops=(), title="music"), chance=0.12)
GUITAR, FAN = Spec(_thing("guitar"), chance=0.12), Spec(_thing("fan"), chance=0.1)
CRIB = Spec(_piece("crib", before=0.6, tops=(), title="child"), chance=0.06)
SUITCASE, LADDER = Spec(_thing("suitcase"), 0, 2, chance=0.5), Spec(_thing("ladder"), chance=0.4)
OTTOMAN = Spec(_of(storing.thing, "ottoman", "free"), chance=0.25)
SOFA, MEDIA = Spec(sitting.sofa_place, 1, 1), Spec(sitting.media, 0, 1, chance=0.9, faces="sitting")
PLANT, BIN = Spec(_thing("plant_pot"), 0, 2), Spec(_thing("trash_bin"), 0, 1)
BASKET, FLOOR_LAMP = Spec(_thing("basket"), 0, 1), Spec(_thing("floor_lamp"), 0, 1)
SHELF = Spec(_piece("bookshelf", before=0.5), 0, 2)
DRAWERS = Spec(_of(sleeping.clothes, "dresser", (0.8, 1.4)), 0, 1, chance=0.6)
WARDROBE = Spec(sleeping.clothes, 0, 1, chance=0.8)
CABINET = Spec(_piece("cabinet", width=(0.7, 1.6)), 0, 2)
FILES = Spec(_of(storing.row, "file_cabinet", 4), 0, 1)
DESK = Spec(_of(working.desk_place), 0, 1)
READING = Spec(sitting.reading_corner, 0, 1, chance=0.7)
KITCHEN = Spec(kitchen.kitchen, 1, 1)
STACKS = Spec(storing.boxes, 1, 6, each=4.0)
RACKS = Spec(_of(storing.row, "bookshelf", 4), 1, 3, each=6.0)
COPIER = Spec(_piece("cabinet", width=(0.6, 1.0), tops=("printer",), height=0.75, fewest=1,
                     title="printing"), 1, 2)  # fmt: skip
WASHING = Spec(_of(wet.laundry), 1, 1)
TOILET = Spec(_of(wet.fixture, "toilet"), 1, 1)
WASHSTAND = Spec(wet.washstand, 1, 1)
TABLE_AT_WALL = Spec(
    _piece("table", width=(1.2, 1.8), height=0.74, most=3, tops=("printer", "box", "telephone"),
           title="table"), 0, 2,
)  # fmt: skip

PROGRAMS: Final[dict[str, RoomProgram]] = {
    "apartment": RoomProgram(
        (24, 34, 55),
        (KITCHEN, Spec(_of(sleeping.bed_place, 0.7), 1), SOFA, MEDIA,
         Spec(_of(sitting.dining, (2, 4)), chance=0.8), WARDROBE, DESK, SHELF, PLANT, BASKET, BIN),
        aspect=(1.1, 1.7), doors=(1, 2), windows=(2, 4), glazed=0.25,
        curtains=0.6,
    ),
    "bathroom": RoomProgram(
        (3.6, 6, 12),
        (Spec(wet.bathing, 1), TOILET, WASHSTAND,
         Spec(_of(wet.laundry, 1), chance=0.35), Spec(_piece("cabinet", width=(0.35, 0.6),
              before=0.4, tops=()), chance=0.6), Spec(_thing("basket"), 1, 1),
         Spec(_thing("trash_bin"), 1)),
        _PLAIN, (1.0, 1.9), (2.4, 2.6), (1, 1), (0, 1), high_windows=True, swing_out=0.3,
        hangs=(("wall_shelf", 2, 2), ("towel_rail", 1, 1), ("wall_lamp", 0, 2), ("picture", 0, 1)),
        lux=(150, 300),
        curtains=0.5,
    ),
    "bedroom": RoomProgram(
        (9, 14, 26),
        (Spec(sleeping.built_in, chance=0.4), Spec(_of(sleeping.bed_place, 0.7), 1),
         Spec(sleeping.clothes, chance=0.6, unless="clothes"), DRAWERS, CRIB, GUITAR, FAN,
         Spec(_of(working.desk_place, "chair"), chance=0.45), READING, SHELF, PLANT, BASKET),
        windows=(1, 2), hangs=(("wall_shelf", 0, 1), ("picture", 0, 3), ("clock", 0, 1),
               ("wall_lamp", 0, 1)),
        lux=(80, 180),
        curtains=0.8,
    ),
    "hotel": RoomProgram(
        (16, 24, 36),
        (Spec(_of(sleeping.bed_place, 1.0), 1, 2, each=14.0),
         Spec(_of(working.desk_place, "chair", "laptop", 3), 1), WARDROBE,
         Spec(_of(sleeping.clothes, "dresser", (0.9, 1.4)), faces="sleeping"), READING,
         Spec(_piece("bench", before=0.4, tops=()), chance=0.5), PLANT, BIN),
        _PLAIN, (1.2, 1.9), glazed=0.4, lux=(90, 180),
        hangs=(("picture", 1, 3), ("wall_lamp", 0, 2)),
        curtains=0.9,
    ),
    "bookstore": RoomProgram(
        (35, 70, 130),
        (Spec(_of(wet.counters, ("counter", "counter"), ("laptop", "telephone", "jar"),
              "reception"), 1),
         Spec(_of(storing.row, "bookshelf", 6), 2, 6, each=14.0),
         Spec(_of(storing.aisle, "bookshelf", 4), 1, 5, each=18.0),
         Spec(_of(sitting.dining, (1, 2), "stool", False, ("box", "bowl"), "display"), 0, 2,
              each=30.0), READING, PLANT, BIN),
        windows=(1, 4), height=(2.8, 3.6), glazed=0.6, lux=(200, 350),
    ),
    "library": RoomProgram(
        (35, 75, 140),
        (Spec(_of(storing.row, "bookshelf", 6), 2, 6, each=14.0),
         Spec(_of(storing.aisle, "bookshelf", 5), 1, 5, each=18.0),
         Spec(_of(sitting.dining, (4, 8), "chair", False, ("laptop", "table_lamp"), "study"), 1, 3,
              each=30.0), READING, DESK, PLANT, BIN),
        windows=(2, 6), height=(2.8, 3.8), lux=(200, 350),
        curtains=0.15,
    ),
    "classroom": RoomProgram(
        (36, 56, 90),
        (Spec(working.classroom, 1), CABINET, SHELF, BIN, PLANT),
        {"rectangle": 8, "L": 1, "slant": 1}, (1.05, 1.5), (2.8, 3.4), (1, 2), (2, 5),
        hangs=_CLASS, lux=(250, 400),
        curtains=0.4,
    ),
    "closet": RoomProgram(
        (2.4, 4.5, 9),
        (Spec(_of(sleeping.clothes, "wardrobe", (0.8, 2.0)), 1),
         Spec(_piece("bookshelf", before=0.45), chance=0.5), DRAWERS, Spec(storing.boxes, 0, 2),
         SUITCASE, BASKET),
        {"rectangle": 8, "chamfer": 1, "slant": 0.5}, (1.0, 1.8), (2.3, 2.6), (1, 1), (0, 0),
        swing_out=1.0, hangs=(), lux=(100, 200),
    ),
    "computer_cluster": RoomProgram(
        (30, 50, 90),
        (Spec(_of(working.workstations, 4, double=True), 1, 5, each=14.0),
         Spec(_of(working.workstations, 5), 0, 4, each=16.0), COPIER, FILES, BIN, PLANT),
        {"rectangle": 8, "L": 1}, (1.1, 1.6), (2.6, 3.2), (1, 2), (1, 4), hangs=_WORK,
        lux=(250, 400),
        curtains=0.5,
    ),
    "conference_room": RoomProgram(
        (18, 30, 55),
        (Spec(working.conference, 1), Spec(_piece("cabinet", width=(1.2, 1.8), height=0.75,
              most=4)), PLANT, BIN),
        {"rectangle": 8, "L": 1, "slant": 1, "chamfer": 1}, (1.2, 1.8), (2.6, 3.2), (1, 2), (1, 4),
        hangs=(("whiteboard", 1, 1), ("clock", 0, 1), ("picture", 0, 2)), lux=(200, 350),
        curtains=0.6,
    ),
    "copy_room": RoomProgram(
        (7, 12, 22),
        (COPIER, TABLE_AT_WALL, Spec(_of(storing.row, "bookshelf", 3), 1), FILES,
         Spec(storing.boxes, 1, 3), BIN, BIN),
        _PLAIN, (1.0, 1.7), doors=(1, 2), windows=(0, 1), hangs=_WORK, lux=(200, 300),
        curtains=0.3,
    ),
    "mail_room": RoomProgram(
        (9, 16, 28),
        (Spec(_of(storing.row, "bookshelf", 5), 1, 2), TABLE_AT_WALL,
         Spec(_of(sitting.dining, (1, 2), "stool", False, ("box", "basket"), "sorting")),
         Spec(storing.boxes, 2, 5), COPIER, Spec(_of(storing.row, "file_cabinet", 3)), BASKET, BIN),
        _PLAIN, (1.0, 1.7), doors=(1, 2), windows=(0, 2), hangs=_WORK, lux=(200, 300),
    ),
    "dining_room": RoomProgram(
        (11, 17, 32),
        (Spec(_of(sitting.dining, (4, 8)), 1), Spec(_piece("cabinet", width=(1.2, 1.8), height=0.85,
              most=4), 1), Spec(_piece("cabinet", width=(0.8, 1.2), height=1.9), chance=0.4),
         Spec(_thing("plant_pot"), 0, 2), FLOOR_LAMP),
        glazed=0.3,
        curtains=0.5,
    ),
    "game_room": RoomProgram(
        (18, 28, 50),
        (Spec(_of(storing.standalone, "pool_table", 0.9, "pool"), chance=0.6), SOFA, MEDIA,
         Spec(_of(sitting.dining, (3, 5), "chair", True, ("bowl", "bottle"), "game"), 1, 2,
              each=22.0),
         Spec(_of(working.desk_place, "office_chair", "monitor"), chance=0.7), SHELF,
         Spec(_piece("cabinet", width=(0.9, 1.5), tops=("bottle", "bowl"), most=3)), PLANT, BIN),
        hangs=(("picture", 1, 4), ("clock", 0, 1)),
        curtains=0.3,
    ),
    "gym": RoomProgram(
        (30, 60, 120),
        (Spec(_of(storing.row, "bench", 3, 0.6), 0, 2),
         Spec(_of(storing.standalone, "bench"), 2, 6, each=14),
         Spec(_of(storing.row, "treadmill", 3, 1.0), chance=0.8),
         Spec(storing.mat, 2, 8, each=10.0), Spec(_thing("exercise_ball"), 0, 3),
         Spec(_of(storing.row, "wardrobe", 3), chance=0.5),
         Spec(_piece("cabinet", width=(0.9, 1.6), tops=("bottle", "speaker"), height=0.9)),
         Spec(_of(storing.boxes, 3), 0, 2), Spec(_thing("speaker"), 0, 2), BASKET, BIN, PLANT),
        _PLAIN, (1.1, 1.8), (2.8, 4.0), (1, 2), (1, 5), glazed=0.4, hangs=_CLASS, lux=(200, 350),
    ),
    "hallway": RoomProgram(
        (6, 11, 24),
        (Spec(_piece("cabinet", width=(0.6, 1.0), before=0.45, height=0.85), chance=0.7),
         Spec(_piece("bench", before=0.4, tops=()), chance=0.5), Spec(_shoe_rack, chance=0.5),
         Spec(_of(sleeping.clothes, "wardrobe", (0.8, 1.2)), chance=0.4), PLANT, BASKET,
         FLOOR_LAMP),
        {"rectangle": 5, "L": 3, "T": 1}, (1.8, 4.0), doors=(2, 3), windows=(0, 1),
        hangs=(("picture", 1, 4), ("wall_lamp", 0, 3), ("clock", 0, 1)), lux=(80, 160),
    ),
    "kitchen": RoomProgram(
        (7.5, 13, 24),
        (KITCHEN, Spec(kitchen.island, chance=0.35), Spec(_of(sitting.dining, (2, 4)), chance=0.85),
         Spec(_piece("cabinet", width=(0.6, 1.0), height=1.9), chance=0.25), BIN, PLANT),
        windows=(1, 2), doors=(1, 2), lux=(180, 300), sills=(1.05, 1.1, 1.15), glazed=0.0,
        hangs=(("wall_shelf", 0, 1), ("picture", 0, 2), ("clock", 0, 1)),
        curtains=0.5,
    ),
    "laundry_room": RoomProgram(
        (4.5, 8, 15),
        (WASHING, Spec(_of(wet.fixture, "sink", beside=0.05), chance=0.6),
         Spec(_piece("cabinet", width=(0.6, 1.2), before=0.5, tops=("basket", "bottle"))),
         Spec(_of(wet.counters, ("counter",), ("basket", "bottle", "jar")), chance=0.6),
         Spec(_piece("ironing_board", before=0.5, tops=()), chance=0.5),
         Spec(_thing("basket"), 1, 2), BIN),
        _PLAIN, (1.0, 1.8), doors=(1, 2), windows=(0, 1), hangs=_BARE, lux=(150, 250),
    ),
    "lounge": RoomProgram(
        (22, 36, 70),
        (Spec(sitting.sofa_place, 1, 3, each=18.0), Spec(sitting.reading_corner, 0, 2),
         Spec(_of(sitting.dining, (2, 4)), 0, 2, each=25.0), MEDIA, SHELF,
         Spec(_of(wet.counters, ("counter", "refrigerator")), chance=0.4),
         Spec(_thing("plant_pot"), 1, 3), BIN, FLOOR_LAMP),
        height=(2.6, 3.2), glazed=0.4, windows=(1, 4),
        curtains=0.3,
    ),
    "living_room": RoomProgram(
        (15, 24, 45),
        (SOFA, MEDIA, Spec(_of(sitting.dining, (4, 6)), chance=0.45), READING, PIANO,
         Spec(_piece("fireplace", before=0.7, width=(1.1, 1.5), title="fireplace"), chance=0.2),
         SHELF, CABINET, Spec(_thing("plant_pot"), 0, 3), FLOOR_LAMP, GUITAR, FAN, OTTOMAN,
         BASKET),
        glazed=0.3, windows=(1, 3),
        hangs=(("wall_shelf", 0, 1), ("picture", 0, 4), ("clock", 0, 1)),
        curtains=0.7,
    ),
    "lobby": RoomProgram(
        (30, 55, 110),
        (Spec(_of(wet.counters, ("counter", "counter"), ("telephone", "laptop", "jar"),
              "reception"), 1),
         Spec(sitting.sofa_place, 1, 3, each=22.0), Spec(sitting.reading_corner, 0, 2),
         Spec(_piece("bench", before=0.4, tops=()), 0, 2), MEDIA, Spec(_thing("plant_pot"), 1, 5),
         BIN),
        height=(2.8, 4.2), doors=(2, 3), windows=(1, 5), glazed=0.6,
        curtains=0.15,
    ),
    "office": RoomProgram(
        (9, 16, 32),
        (Spec(_of(working.desk_place), 1, 3, each=8.0), FILES, SHELF,
         Spec(_of(sitting.dining, (2, 4), "chair", False, ("laptop", "bottle"), "meeting"),
              chance=0.4), CABINET, COPIER, Spec(_thing("water_cooler"), chance=0.25), FAN,
         PLANT, BIN),
        hangs=_WORK, lux=(220, 350),
        curtains=0.6,
    ),
    "stairs": RoomProgram(
        (9, 15, 26),
        (Spec(storing.stairs, 1), Spec(_piece("cabinet", width=(0.6, 1.0), before=0.45),
              chance=0.6), Spec(_piece("bench", before=0.4, tops=()), chance=0.4),
         PLANT, FLOOR_LAMP),
        {"rectangle": 6, "L": 1, "slant": 0.5}, (1.2, 2.2), (3.6, 5.2), (1, 2), (0, 2),
        hangs=(("picture", 0, 3), ("wall_lamp", 1, 3)), lux=(90, 180),
    ),
    "storage": RoomProgram(
        (5, 11, 26),
        (RACKS, Spec(_of(storing.aisle, "bookshelf", 3), 0, 2, each=14.0), STACKS,
         Spec(_of(storing.row, "file_cabinet", 3), chance=0.4), LADDER, SUITCASE,
         Spec(_piece("cabinet", width=(0.8, 1.2), height=1.9), chance=0.4), BASKET, BIN),
        _PLAIN, (1.0, 1.9), doors=(1, 1), windows=(0, 1), high_windows=True, hangs=(),
    ),
    "basement": RoomProgram(
        (14, 26, 55),
        (Spec(_of(storing.row, "bookshelf", 4), 1, 2), Spec(_of(wet.laundry, 2), chance=0.7),
         Spec(_piece("table", width=(1.2, 1.8), height=0.85, tops=("box", "jar", "bottle"), most=4,
              title="bench"), chance=0.8),
         Spec(_piece("refrigerator", before=0.6, tops=()), chance=0.4),
         Spec(_of(storing.boxes, 5), 2, 7, each=5.0), CABINET, BASKET,
         Spec(_thing("stool"), 0, 2)),
        _MIXED, height=(2.2, 2.45), windows=(0, 2), high_windows=True, hangs=_BARE, lux=(90, 180),
    ),
    "garage": RoomProgram(
        (18, 30, 50),
        (Spec(_piece("table", width=(1.4, 2.2), height=0.88, tops=("box", "jar", "bottle"), most=4,
              title="workbench"), 1), Spec(_of(storing.row, "bookshelf", 4), 1, 2),
         Spec(_of(storing.row, "cabinet", 3), chance=0.6), Spec(_of(storing.boxes, 5), 1, 5,
              each=6.0), Spec(_piece("refrigerator", before=0.6, tops=()), chance=0.3),
         Spec(_thing("stool"), 0, 2), LADDER, BIN, BASKET),
        {"rectangle": 8, "L": 1}, (1.0, 1.7), (2.4, 2.9), (1, 1), (0, 2), high_windows=True,
        gate=0.8, hangs=_BARE, lux=(120, 220),
    ),
    "misc": RoomProgram(
        (8, 18, 40),
        (Spec(_piece("table", width=(1.0, 1.6), height=0.74, most=3), chance=0.6), SHELF, CABINET,
         Spec(_of(sitting.dining, (2, 4)), chance=0.5), READING, DESK,
         Spec(_of(storing.boxes, 4), 0, 3), Spec(_thing("chair"), 0, 2), PLANT, BASKET, BIN),
        doors=(1, 3), windows=(0, 3),
        curtains=0.2,
    ),
}  # fmt: skip
