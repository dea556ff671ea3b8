"""The command ``view``."""

from pathlib import Path
from typing import Any, Final

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command
from openrooms_usd.cli.pages import page_options, show
from openrooms_usd.errors import InputError
from openrooms_usd.view.app import App

_STAGES: Final = {".usd", ".usda", ".usdc", ".usdz"}


@click.command(
    cls=Command,
    example="orusd view out/scene.usda --export room.html",
    former={"--light": "--lightmaps"},
)
@click.argument("what", type=click.Path(path_type=Path), metavar="STAGE|RENDER|SCAN")
@click.option(
    "--lightmaps",
    "light",
    type=click.Path(path_type=Path),
    metavar="LIT",
    multiple=True,
    help="What `orusd bake` wrote of STAGE. Several are of times of day, in their order: "
    "a slider goes from one to the next.",
)
@click.option(
    "--render",
    type=click.Path(path_type=Path),
    metavar="RENDER",
    help="A finished render of STAGE, to be shown from its cameras.",
)
@click.option(
    "--photographs",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Where the photographs of STAGE's capture lie.",
)
@click.option(
    "--importer",
    default="scan",
    show_default=True,
    metavar="KIND",
    help="What reads SCAN: a kind of `orusd import`.",
)
@click.option(
    "--include-outside",
    is_flag=True,
    help="Show pictures outside the folders of STAGE and LIT too.",
)
@page_options
def view(
    what: Path,
    light: tuple[Path, ...],
    render: Path | None,
    photographs: Path | None,
    importer: str,
    include_outside: bool,
    **where: Any,
) -> None:
    """Look at a room, a render of it, or a scan in the browser.

    A RENDER is a folder that `orusd render` wrote beside its stage, a SCAN what `orusd import`
    reads.
    """
    more = {"light": light, "include_outside": include_outside, "photographs": photographs}
    with progress_bar("reading"):
        page = _page(what, render, importer, **more)
    show(page, **where)


def _page(what: Path, render: Path | None = None, importer: str = "scan", **more: Any) -> App:
    from openrooms_usd.view.room import room_app

    if what.suffix.lower() in _STAGES:
        return room_app(what, render=render, **more)
    if (what / "manifest.json").is_file():
        return room_app(_stage_of(what), render=what, **more)
    from openrooms_usd.view.scanned import scan_app

    return scan_app(what, importer=importer)


def _stage_of(render: Path) -> Path:
    """The stage of a render, where it lies beside it or one folder above."""
    from openrooms_usd import untrusted
    from openrooms_usd.rendering.manifest_schema import read_manifest

    name = Path(read_manifest(render).stage or "scene.usda").name
    for folder in (render.absolute().parent, render.absolute().parent / "out"):
        if untrusted.kind_of(folder / name) == "a file":
            return folder / name
    raise InputError(
        "the stage of this render is not beside it",
        place=render,
        remedy=f"orusd view STAGE --render {render}",
    )
