"""Try an installed wheel: schemas and adapters are found, and a small room composes and renders.

Its light is rendered with the LLVM that pip brought; without any the same is refused, in words.

Run it with the environment's Python from a folder that is not the checkout.
"""

import os
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

from pxr import Usd

import openrooms_usd
import orusd_schemas
from orusd_mitsuba.llvm import VARIABLE


def main(out: Path) -> None:
    """Check the installation; compose, validate and render the bundled example into ``out``."""
    assert Path(sys.prefix) in Path(openrooms_usd.__file__).parents, openrooms_usd.__file__
    assert orusd_schemas.PATH.joinpath("room.schema.json").is_file()
    assert Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("OpenRoomsRoomAPI")
    for kind in ("importers", "renderers", "exporters"):
        found = list(entry_points(group=f"openrooms_usd.{kind}"))
        assert found, f"no {kind}"
        print(kind, [type(point.load()()).__name__ for point in found])

    orusd = str(Path(sys.executable).with_name("orusd"))
    demo = Path(openrooms_usd.__file__).parent / "demo"
    commands = (
        ("--help",),
        ("compose", demo / "room.yaml", "-o", out, "--flatten", "--usdz"),
        ("validate", out / "scene.usda", "--strict"),
        ("validate", out / "scene.usdz"),
        ("render", out / "scene.usda", "-o", out / "render", "--resolution", "64x48", "--spp", "4"),
    )
    for command in commands:
        print("$ orusd", *command, flush=True)
        subprocess.run([orusd, *map(str, command)], check=True, cwd=out.parent)
    assert (out / "render" / "manifest.json").is_file()
    assert (out / "render" / "contact_sheet.png").is_file()

    light = [orusd, "render", str(out / "scene.usda"), "--resolution", "64x48", "--spp", "4"]
    light += ["--channels", "irradiance,radiance_i", "-o"]
    subprocess.run([*light, str(out / "light")], check=True)
    none = {**os.environ, VARIABLE: str(out / "no-such-library")}
    refused = subprocess.run(
        [*light, str(out / "none")], env=none, capture_output=True, text=True, check=False
    )
    print(refused.stderr)
    assert refused.returncode != 0 and "irradiance" in refused.stderr
    assert "Traceback" not in refused.stderr and not (out / "none").exists()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
