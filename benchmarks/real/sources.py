"""Where public captures come from; none is part of the project, for their licences' sake."""

from typing import Final, NamedTuple


class Source(NamedTuple):
    """Files of a public repository, at one of its commits."""

    capture: str
    repository: str
    commit: str
    path: str
    terms: str


_S3DIS: Final = (
    "T0M0F/pointnet",
    "05ae2f8b5bcdb8fd9e8e4104540f494b87d18df6",
    "sem_seg/log6/dump/Area_6_{room}_gt.obj, _gt.txt, _pred.txt",
    "S3DIS: research only",
)
_ROOMS: Final = (
    "copyRoom_1",
    "hallway_3",
    "hallway_5",
    "office_10",
    "office_17",
    "office_26",
    "office_36",
    "pantry_1",
)

SOURCES: Final = (
    *(
        Source(f"s3dis_6_{room}", _S3DIS[0], _S3DIS[1], _S3DIS[2].format(room=room), _S3DIS[3])
        for room in _ROOMS
    ),
    Source(
        "scannet_0470_00",
        "skanti/Scan2CAD",
        "99c8b9565617b43a9ad03d0dbeb9141805b00618",
        "Assets/scannet-sample/scene0470_00",
        "ScanNet: research only",
    ),
    Source(
        "polycam_room",
        "tamatebox/audio-infra",
        "fdf7cbf79e85209b9612ebf68ebc4a5cdcbe2c8b",
        "room/scans/room.glb",
        "none stated",
    ),
    Source(
        "scaniverse_office_low",
        "nikitash98/digital_memories",
        "61a8bbb64e4fca35337c26a5e3f8f260a750a73c",
        "office_low.ply",
        "none stated",
    ),
    Source(
        "planefinder_office",
        "zwpdbh/PlaneFinder",
        "f46581126d3307ead47e2f38017673a0eaf0dcd5",
        "data/office.ply",
        "none stated",
    ),
    Source(
        "rotating_lidar_office",
        "senegalo/lidar-room-scanner",
        "428964a8d7e5f807d4e4746646c75c3203a0ce2d",
        "results/combined_cloud_000000.xyz",
        "none stated",
    ),
    Source(
        "roomplan_unity",
        "NamanBhoj/Room-Plan-Update-TELUS",
        "9823282bbda05707339471db2282dc9c54b526e1",
        "Assets/RoomPlanUnityKit/Samples/RPU/Resources/EditorAR/scan.{json,usdz}",
        "none stated",
    ),
    Source(
        "roomplan_libroom",
        "SekharReddy07/AR_PROJECT",
        "6910e14e8d9ba2eadba3704fea977fcb2e58af62",
        "Libroom_output.zip",
        "none stated",
    ),
)
