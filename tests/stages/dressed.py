"""Rooms composed as far as their materials."""

from pathlib import Path

from pxr import Usd

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.stages import runner
from openrooms_usd.stages.alignment.stage import AlignmentStage
from openrooms_usd.stages.draft import drafting
from openrooms_usd.stages.layout.stage import LayoutStage
from openrooms_usd.stages.materials.stage import MaterialsStage


def compose(folder: Path, described: Room) -> Usd.Stage:
    """The room's layout, objects and materials, without lights and physics."""
    with drafting(folder) as draft:
        runner.create_edits(draft)
        for stage in (LayoutStage(), AlignmentStage(), MaterialsStage()):
            runner.run(stage, described, folder, draft, "fingerprint", 1)
        runner.write_scene(draft)
    stage = Usd.Stage.Open(str(folder / names.SCENE))
    stage.Reload()
    return stage
