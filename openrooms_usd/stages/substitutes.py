"""What the library builds for the words of captures: RoomPlan, ScanNet, Scan2CAD and plain ones.

The words are the categories of Apple's RoomPlan, the classes of NYU40 and SUN RGB-D, the raw names
of ScanNet and the names of ShapeNet's synsets, as those data sets spell them.
"""

import re
from collections.abc import Mapping
from typing import Final

UNKNOWN: Final = "box"
"""The category that stands for what the library has nothing for."""

# By category, all other words for it. The category's own name is understood, too.
_WORDS: Final[dict[str, str]] = {
    "armchair": "arm_chair recliner club_chair lounge_chair easy_chair",
    "basket": "laundry_basket hamper laundry_hamper storage_basket",
    "bathtub": "tub bath bathing_tub",
    "bed": "bunk_bed double_bed single_bed mattress crib cot",
    "bench": "piano_bench",
    "bookshelf": "bookcase bookshelves book_shelf shelf shelves shelving rack",
    "bottle": "water_bottle bottles",
    "bowl": "bowls",
    "box": "cardboard_box boxes crate",
    "cabinet": "storage storage_cabinet cupboard sideboard credenza tv_stand tv_cabinet "
    "entertainment_center shoe_cabinet locker",
    "ceiling_lamp": "pendant_lamp chandelier ceiling_light hanging_lamp",
    "chair": "dining_chair folding_chair chairs",
    "clock": "wall_clock alarm_clock",
    "coffee_table": "cocktail_table",
    "counter": "kitchen_counter countertop kitchen_island bar_counter bar",
    "curtain": "curtains shower_curtain blinds drapes drapery",
    "desk": "writing_desk office_desk computer_desk workbench",
    "dishwasher": "dish_washer",
    "dresser": "chest_of_drawers commode drawers drawer bureau",
    "door": "doors doorway",
    "faucet": "tap spigot",
    "file_cabinet": "filing_cabinet file_cabinets",
    "fireplace": "",
    "floor_lamp": "standing_lamp torchiere",
    "jar": "vase pot",
    "keyboard": "computer_keyboard keypad",
    "kitchen_cabinet": "kitchen_cabinets kitchen_cupboard",
    "laptop": "laptop_computer notebook",
    "microwave": "microwave_oven",
    "monitor": "computer_monitor screen computer_screen display",
    "office_chair": "swivel_chair desk_chair task_chair",
    "oven": "built_in_oven",
    "picture": "painting poster pictures photo picture_frame",
    "pillow": "cushion pillows",
    "plant_pot": "plant plants flowerpot flower_pot potted_plant houseplant",
    "printer": "copier photocopier",
    "refrigerator": "fridge freezer refridgerator mini_fridge",
    "rug": "carpet floor_mat bathmat bath_mat mat",
    "side_table": "night_stand nightstand bedside_table end_table",
    "sink": "washbasin wash_basin bathroom_sink kitchen_sink basin",
    "sofa": "couch loveseat love_seat settee futon",
    "speaker": "loudspeaker speakers subwoofer",
    "stairs": "stairway staircase",
    "stool": "bar_stool barstool footstool ottoman",
    "stove": "cooker range kitchen_range cooktop",
    "table": "dining_table conference_table kitchen_table round_table tables",
    "table_lamp": "desk_lamp reading_lamp",
    "telephone": "phone",
    "television": "tv television_set flat_screen",
    "toilet": "lavatory",
    "trash_bin": "trash_can trashcan garbage_bin garbage_can bin recycling_bin waste_basket "
    "wastebasket ashcan dustbin",
    "wall_lamp": "sconce wall_light",
    "wardrobe": "closet armoire wardrobe_closet wardrobe_cabinet",
    "washing_machine": "washer washer_dryer washing_machines clothes_dryer dryer",
    "window": "windows",
    "whiteboard": "white_board blackboard",
}

SUBSTITUTES: Final[dict[str, str]] = {
    word: category for category, words in _WORDS.items() for word in (category, *words.split())
}
"""The library's category by a captured word in plain form."""

# RoomPlan's attributes that say more than the category (CapturedRoom.Object.attributes).
_CLOSER: Final[dict[tuple[str, str, str], str]] = {
    ("chair", "chair_type", "swivel"): "office_chair",
    ("chair", "chair_type", "stool"): "stool",
    ("sofa", "sofa_type", "single_seat"): "armchair",
    ("storage", "storage_type", "shelf"): "bookshelf",
    ("table", "table_type", "coffee"): "coffee_table",
    ("table", "table_type", "desk"): "desk",
}
# A lamp that begins so high above the floor hangs, and so low stands on it, metres.
_HANGS, _STANDS = 1.5, 0.1


def plain(word: str) -> str:
    """A word in lower case with underscores: ``washer_dryer`` for ``washerDryer``.

    It is a valid prim name, also where nothing of the word is left.
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", word)
    name = re.sub(r"[^a-z0-9]+", "_", apart.lower()).strip("_")
    return name if name[:1].isalpha() else f"thing_{name}".rstrip("_")


def substitute(label: str, attributes: Mapping[str, str], above_floor: float) -> str | None:
    """What the library builds for a captured thing.

    Args:
        label: The source's word for it.
        attributes: What the source knows besides.
        above_floor: How high it begins above the floor, metres.

    Returns:
        A category of the library; None when it has nothing for it.
    """
    word = plain(label)
    if word in ("lamp", "light", "lighting"):
        if above_floor > _HANGS:
            return "ceiling_lamp"
        return "floor_lamp" if above_floor < _STANDS else "table_lamp"
    closer = (_CLOSER.get((word, plain(key), plain(value))) for key, value in attributes.items())
    return next((category for category in closer if category), None) or SUBSTITUTES.get(word)
