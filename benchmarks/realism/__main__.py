"""How near pictures of generated rooms are to photographs.

Each --set is a title and a folder with renders that have the channels depth, normal_geometric,
instance and semantic_nyu40, and a denoised picture; --photographs is a folder of JPEG files.
"""

from pathlib import Path

import click

from benchmarks.realism.report import markdown, measured, seen
from benchmarks.report import publish


@click.command(help=__doc__)
@click.option("--set", "sets", type=(str, click.Path(path_type=Path, exists=True)), multiple=True,
              required=True, help="Title and folder of renders; may be repeated.")  # fmt: skip
@click.option("--photographs", type=click.Path(path_type=Path, exists=True))
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(sets: tuple[tuple[str, Path], ...], photographs: Path | None, target: Path | None) -> None:
    found = {title: (measured(folder), *seen(folder)) for title, folder in sets}
    empty = [title for title, (features, views, _) in found.items() if not features or not views]
    if empty:
        raise click.ClickException(
            f"no finished renders with a denoised picture and all channels in: {', '.join(empty)}"
        )
    real = measured(photographs) if photographs else {}
    count = len(next(iter(real.values()))) if real else 0
    data = {
        "sets": {title: {"pictures": a, "geometry": b, "classes": c}
                 for title, (a, b, c) in found.items()},
        "photographs": real,
    }  # fmt: skip
    publish("realism", data, markdown(found, real, count), target)


if __name__ == "__main__":
    main()
