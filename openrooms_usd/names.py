"""The scene contract as constants: prim paths, layer order, taxonomies, units.

Everything that two modules must spell alike stands here once.
"""

import re
from typing import Final

# Prims and the step that defines them. Every other step writes ``over``.
WORLD: Final = "/World"  # layout (assembly)
ROOM: Final = "/World/Room"  # layout (component)
FLOOR: Final = "/World/Room/Floor"
CEILING: Final = "/World/Room/Ceiling"
WALLS: Final = "/World/Room/Walls"
OPENINGS: Final = "/World/Room/Openings"
BEYOND: Final = "/World/Room/Beyond"
TRIM: Final = "/World/Room/Trim"
FURNITURE: Final = "/World/Furniture"  # alignment (group)
MATERIALS: Final = "/World/Materials"  # materials
LIGHTS: Final = "/World/Lights"  # lights
ENVIRONMENT: Final = "/World/Lights/Environment"
PORTALS: Final = "/World/Lights/Portals"
SCREENS: Final = "/World/Lights/Screens"
OUTSIDE: Final = "/World/Outside"  # lights: what stands near the windows
CAMERAS: Final = "/World/Cameras"  # cameras
SPARE_CAMERA: Final = "spare"  # what those are called that are kept in case
PHYSICS: Final = "/World/Physics"  # physics
PHYSICS_SCENE: Final = "/World/Physics/Scene"
ROOM_PHYSICS: Final = "/World/Room/Physics"  # physics
RENDER: Final = "/Render"  # cameras
RENDER_SETTINGS: Final = "/Render/Settings"

# Steps from the weakest to the strongest layer.
STEPS: Final = ("layout", "alignment", "materials", "lights", "cameras", "physics")

# The present name of each section of room.yaml that had another one; its step and layer keep that.
FORMER_SECTIONS: Final = {"alignment": "furniture"}

# What each step defines, with all that lies below. Layout also defines the world.
OWNED: Final = {
    "layout": (ROOM,),
    "alignment": (FURNITURE,),
    "materials": (MATERIALS,),
    "lights": (LIGHTS, OUTSIDE),
    "cameras": (CAMERAS, RENDER),
    "physics": (PHYSICS, ROOM_PHYSICS),
}

# Files of a composed room.
SCENE: Final = "scene.usda"
LAYERS: Final = "layers"
EDITS: Final = "edits"  # layers/edits.usda: the strongest layer, human, never written by us
SETTLED: Final = "settled"  # layers/settled.usda: where things came to rest; no step writes it

# All layers that a scene may stack, strongest first.
STACK: Final = (EDITS, SETTLED, *reversed(STEPS))

# Stage metadata that every layer carries alike.
UP_AXIS: Final = "Z"
METERS_PER_UNIT: Final = 1.0
KILOGRAMS_PER_UNIT: Final = 1.0

# Default height from floor to ceiling, metres, for described, captured and generated rooms. Also of
# a scanned room without a scanned ceiling, as in OpenRooms: openings are searched in its walls up
# to there.
ROOM_HEIGHT: Final = 2.6
SCANNED_HEIGHT: Final = 3.0
# Default thickness of walls inside a room, metres: two boards on a frame.
PARTITION_THICKNESS: Final = 0.1

# customLayerData key and AuthorshipAPI package of our provenance.
NAMESPACE: Final = "openrooms"
CREATOR: Final = "openrooms_usd"

# Taxonomies of SemanticsLabelsAPI.
CATEGORY: Final = "category"  # our own category names
OPENROOMS45: Final = "openrooms45"  # the 45 classes of the released dataset
NYU40: Final = "nyu40"  # the 40 classes of NYU Depth V2
ADE20K: Final = "ade20k"  # the 150 classes of ADE20K's scene parsing benchmark
COCO: Final = "coco"  # the 80 things of COCO
CAPTURED: Final = "captured"  # the source's own word for what was captured
PART: Final = "part"  # semantic parts, named as PartNet does

# The categories that the room itself is made of.
SHELL: Final = frozenset(
    {
        "beam",
        "ceiling",
        "ceiling_grid",
        "cladding",
        "cornice",
        "door",
        "floor",
        "opening",
        "picture_rail",
        "skirting",
        "wainscot",
        "wall",
        "window",
    }
)

# Name of the texture coordinates, in metres.
ST: Final = "st"
# Name of the second set, in 0..1 and without overlaps, for what is baked.
BAKED_ST: Final = "st1"

# The key of assetInfo that says under which terms something may be used, its value for all that
# this package makes, and its value if the terms are not stated.
LICENCE_KEY: Final = "license"
LICENCE: Final = "Apache-2.0"
UNKNOWN_LICENCE: Final = "unknown"

# The variant set that chooses what an object is made of.
LOOK: Final = "look"

# From a light to the surface of a thing that it is the glow of.
SURFACE_OF: Final = "openrooms:light:surface"

# The part of a lamp that emits.
LIGHT_BULB: Final = "light_bulb"

# Attributes of our own schemas that more than one module spells.
OPENING_WIDTH: Final = "openrooms:opening:width"
OPENING_HEIGHT: Final = "openrooms:opening:height"
OPENING_WALL: Final = "openrooms:opening:wall"
OPENING_STYLE: Final = "openrooms:opening:style"
PARTITION_API: Final = "OpenRoomsPartitionAPI"
PARTITION_OUTLINE: Final = "openrooms:partition:outline"
PARTITION_HEIGHT: Final = "openrooms:partition:height"
ROOM_FLOOR: Final = "openrooms:room:floor"
SOURCE_API: Final = "OpenRoomsSourceAPI"
SOURCE_FILE: Final = "openrooms:source:file"
SOURCE_ID: Final = "openrooms:source:id"
SOURCE_CONFIDENCE: Final = "openrooms:source:confidence"
SOURCE_FROM_WORLD: Final = "openrooms:source:fromWorld"
ALIGNMENT_API: Final = "OpenRoomsAlignmentAPI"
ALIGNMENT_RESIDUAL: Final = "openrooms:alignment:residual"
ALIGNMENT_COVERAGE: Final = "openrooms:alignment:coverage"
ALIGNMENT_SYMMETRY: Final = "openrooms:alignment:symmetry"
ALIGNMENT_SUPPORT: Final = "openrooms:alignment:support"
ALIGNMENT_CARRIER: Final = "openrooms:alignment:carrier"
MATERIAL_API: Final = "OpenRoomsMaterialAPI"
MATERIAL_CATEGORY: Final = "openrooms:material:category"
MATERIAL_FAMILY: Final = "openrooms:material:family"
MATERIAL_NUMBER: Final = "openrooms:material:number"
MATERIAL_SIZE: Final = "openrooms:material:size"
MATERIAL_TRANSMISSION: Final = "openrooms:material:transmission"
MATERIAL_F0: Final = "openrooms:material:f0"
MATERIAL_PANE: Final = "openrooms:material:pane"
MATERIAL_FRICTION_SPREAD: Final = "openrooms:material:frictionSpread"
JOINT_API: Final = "OpenRoomsJointAPI"
JOINT_TYPE: Final = "openrooms:joint:type"
JOINT_AXIS: Final = "openrooms:joint:axis"
JOINT_LOWER: Final = "openrooms:joint:lower"
JOINT_UPPER: Final = "openrooms:joint:upper"
JOINT_FRICTION: Final = "openrooms:joint:friction"

# Styles of doors that let light pass while they are shut.
SEE_THROUGH: Final = frozenset({"glazed"})

_DIGITS: Final = re.compile(r"([0-9]{1,18})")


def natural_sort_key(name: str) -> list[tuple[int, str]]:
    """A key by which names are sorted as people count: ``view_10`` comes after ``view_9``."""
    parts = _DIGITS.split(name)
    return [(int(part), "") if place % 2 else (0, part) for place, part in enumerate(parts)]


def section_of(step: str) -> str:
    """The section of room.yaml that a step makes a layer of."""
    return FORMER_SECTIONS.get(step, step)


def leaf(number: int) -> str:
    """The name of a door's leaf below its opening."""
    return f"Leaf_{number}" if number else "Leaf"
