"""Rooms composed as far as their materials."""

from pathlib import Path

from pxr import Usd

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.steps import runner
from openrooms_usd.steps.alignment.step import AlignmentStep
from openrooms_usd.steps.draft import drafting
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.materials.step import MaterialsStep


def compose(folder: Path, described: Room) -> Usd.Stage:
    """The room's layout, objects and materials, without lights and physics."""
    with drafting(folder) as draft:
        runner.create_edits(draft)
        for step in (LayoutStep(), AlignmentStep(), MaterialsStep()):
            runner.run(step, described, folder, draft, "fingerprint", 1)
        runner.write_scene(draft)
    stage = Usd.Stage.Open(str(folder / names.SCENE))
    stage.Reload()
    return stage
