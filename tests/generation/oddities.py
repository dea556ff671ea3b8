"""What nobody has at home: two kettles, unlike wardrobes side by side, a chandelier over a bath."""

from collections import Counter
from collections.abc import Iterator, Sequence

from openrooms_usd.generation.items import Item

# How many of a thing a room has at most.
MOST = {"remote_control": 2, "kettle": 1, "microwave": 1, "clock": 1, "candle": 5, "photo_frame": 6}
# Of what people buy for one room, all are of one style; but teachers have their own desk.
SETS = ("wardrobe", "desk", "bed", "sofa")
TEACHING = ("classroom", "desk")
# Where chandeliers hang in no house.
PLAIN_LIGHT = {"bathroom", "kitchen", "laundry_room", "office", "garage", "closet", "storage"}
# The middle of a clock is where people look, metres.
EYE_LEVEL = (1.4, 1.95)


def odd(room_type: str, items: Sequence[Item]) -> Iterator[str]:
    """Everything that a person would wonder about, one sentence each."""
    counts = Counter(item.category for item in items)
    for name, most in MOST.items():
        if counts[name] > most:
            yield f"there are {counts[name]} of {name}"
    for name in SETS:
        made = {item.style for item in items if item.category == name and _stands(item)}
        if len(made) > 1 and (room_type, name) != TEACHING:
            yield f"{name} is {' and '.join(sorted(made))}"
    machines = Counter(item.style for item in items if item.category == "washing_machine")
    if max(machines.values(), default=0) > 1:
        yield "equal washing machines stand side by side"
    for item in items:
        if item.style == "chandelier" and room_type in PLAIN_LIGHT:
            yield f"a chandelier hangs in a {room_type}"
        if item.category == "clock" and item.on == "wall":
            if item.style == "mantel":
                yield "a clock for a mantelpiece hangs on a wall"
            middle = item.z + 0.5 * item.size[2]
            if not EYE_LEVEL[0] <= middle <= EYE_LEVEL[1]:
                yield f"a clock hangs {middle:.2f} m high"


def _stands(item: Item) -> bool:
    return item.on == "floor" or not item.lies
