"""The command ``render``."""

from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command, folder_option, section
from openrooms_usd.cli.console import Choice, asked, echo, gathered, most, named, print_result, warn
from openrooms_usd.cli.reports import check_report, report_option, write_report
from openrooms_usd.cli.settings import RENDERER, settings_options
from openrooms_usd.description.rendering import RenderSettings, flag_of
from openrooms_usd.rendering.contract import DEFAULT_RATE

if TYPE_CHECKING:
    from pxr import Usd

    from openrooms_usd.rendering import RenderSummary


# Of a channel's sum, and beyond so many standard errors: a render has some sixty channels, and
# light that few paths find has heavy tails.
_BIAS_WORTH_A_WARNING: Final = 0.03
_SURE_STANDARD_ERRORS: Final = 4.0
# Sentences of the report that are printed.
_MOST_ALARMS: Final = 8

_FILM: Final = (
    "resolution",
    "samples",
    "seed",
    "bounces",
    "method",
    "tone",
    "denoise",
    "default_light",
    "texture_side",
    "time_code",
    "renderer",
    "options",
)
"""The settings that a video has; others are those of single views."""

# Each option of a render is one of the command.
_SETTINGS: Final = tuple(name for name in RenderSettings.model_fields if name not in RENDERER)


@click.command(
    cls=Command,
    example="orusd render out/scene.usda -o renders --camera overview --spp 16",
    former={
        "--error": "--target-error",
        "--time": "--max-seconds",
        "--frames": lambda value: "--time-codes" if value else "--keep-frames",
    },
)
@click.argument("stage", type=click.Path(path_type=Path), metavar="STAGE")
@folder_option
@click.option(
    "--camera",
    "cameras",
    multiple=True,
    metavar="NAME_OR_PATH",
    help="A camera to render; all by default. Repeatable.",
)
@settings_options(
    *_SETTINGS,
    shorthands={
        "variant": "The backend: auto, cuda, llvm or scalar.",
        "bsdf": "How surfaces reflect: auto, openrooms or preview.",
    },
)
@section(
    "Video",
    click.option(
        "--path",
        "spec",
        metavar="PATH",
        help="Write a video: walk, a camera that moves, or a file of keys (docs/howto/paths.md).",
    ),
    click.option("--duration", type=float, help="Seconds of the video; 10 for a walk."),
    click.option(
        "--fps", type=int, help=f"Frames a second of the video; {DEFAULT_RATE} by default."
    ),
    click.option("--keep-frames", is_flag=True, help="Write every frame of the video too."),
)
@click.option(
    "--time-codes",
    metavar="A:B:STEP",
    help="Render a stage that moves at these moments, into a folder for each.",
)
@section(
    "OpenRooms' files",
    click.option(
        "--dataset",
        "root",
        type=click.Path(path_type=Path),
        metavar="ROOT",
        help="Also write OpenRooms' files there, as `orusd dataset write` does.",
    ),
    click.option(
        "--dataset-layout",
        "layout",
        type=Choice(["split", "merged"]),
        default="split",
        show_default=True,
        help="With --dataset: a tree for each channel as released, or one folder, which is what "
        "the published loaders read.",
    ),
)
@report_option
def render(
    stage: Path,
    out: Path,
    cameras: tuple[str, ...],
    settings: RenderSettings,
    spec: str | None,
    duration: float | None,
    fps: int | None,
    keep_frames: bool,
    time_codes: str | None,
    root: Path | None,
    layout: Literal["split", "merged"],
    report_file: Path | None,
) -> None:
    """Render the cameras of a USD stage with their ground truth, or a camera path as a video.

    OUT receives a folder for every view, contact_sheet.png, manifest.json and timing.json. Ctrl-C
    keeps the views that are finished. With --time-codes all this is in a folder for each, such
    as OUT/frame_0012.
    """
    from openrooms_usd import adapters
    from openrooms_usd.cli.datasets import print_dataset
    from openrooms_usd.rendering import render_stage
    from openrooms_usd.rendering.datasets import DatasetOptions, DatasetWriter
    from openrooms_usd.rendering.reading import read_render
    from openrooms_usd.usd.files.diagnostics import quiet

    # Held until the end, so that its files are read once.
    _held = _warn_of_units(stage)
    if spec is not None:
        _check_film(settings, cameras, root, report_file, time_codes)
        film(
            stage,
            out,
            spec,
            settings,
            seconds=duration,
            rate=DEFAULT_RATE if fps is None else fps,
            keep_frames=keep_frames,
        )
        return
    if duration is not None or fps is not None or keep_frames:
        raise click.UsageError("--duration, --fps and --keep-frames belong to --path")
    if time_codes is not None and report_file is not None:
        raise click.UsageError("with --time-codes there is no --report: frames have manifests")
    check_report(report_file, stage, out)
    renders = _renders(out, settings.time_code, time_codes, root)
    for folder in renders:
        _tell_what_goes(folder)
    # What cannot be written should not be rendered first.
    writer: DatasetWriter | None = adapters.load(adapters.DATASETS, "openrooms") if root else None
    summaries: list[RenderSummary] = []
    for folder, when in renders.items():
        wanted = settings if when is None else settings.replace(time_code=when)
        with quiet(), progress_bar("translating") as progress:
            summary = render_stage(stage, folder, wanted, cameras=cameras, progress=progress)
        if not asked().json:  # The document has the warnings too.
            _print_summary(summary)
        summaries.append(summary)
    write_report(report_file, summaries[0].report)
    written = None
    if writer and root:
        written = writer.write([read_render(out)], root, DatasetOptions(layout=layout))
    if time_codes:
        print_result({"frames": [summary.as_dict() for summary in summaries]})
    else:
        print_result(summaries[0].as_dict() | ({"dataset": written.as_dict()} if written else {}))
    if written:
        print_dataset(written)


def _check_film(
    settings: RenderSettings,
    cameras: tuple[str, ...],
    root: Path | None,
    report_file: Path | None,
    time_codes: str | None,
) -> None:
    """Refuse what a video does not have."""
    given = [flag_of(name) for name in _SETTINGS if name in settings.model_fields_set - {*_FILM}]
    others = {
        "--camera": cameras,
        "--dataset": root,
        "--report": report_file,
        "--time-codes": time_codes,
    }
    given += [flag for flag, value in others.items() if value]
    if given:
        raise click.UsageError(
            f"a video (--path) has no {', '.join(given)}; --keep-frames keeps its frames with "
            "their ground truth"
        )


def _renders(
    out: Path, time_code: float | None, time_codes: str | None, dataset: Path | None
) -> dict[Path, float | None]:
    """The folders to write, each with the time code it shows."""
    from openrooms_usd.rendering.frames import frame_folders, frames_of

    if time_codes is None:
        return {out: time_code}
    if time_code is not None or dataset is not None:
        raise click.UsageError(
            "with --time-codes there is no --time-code or --dataset: `orusd dataset write` takes "
            "each folder afterwards"
        )
    return {**frame_folders(out, frames_of(time_codes))}


def _warn_of_units(stage: Path) -> "Usd.Stage":
    """Say before the picture what in it is a hundred times too large, and give the stage."""
    from openrooms_usd.usd.files.diagnostics import quiet
    from openrooms_usd.usd.files.layers import open_stage
    from openrooms_usd.usd.places.metrics import find_unit_mismatches

    with quiet():
        opened = open_stage(stage)
        found = find_unit_mismatches(opened)
    for misfit in found:
        warn(f"{misfit}: see orusd edit fix-units")
    return opened


def _tell_what_goes(out: Path) -> None:
    """Say before the picture that the views of an earlier render will go."""
    from openrooms_usd.rendering.folder import listed_views

    if earlier := sorted(listed_views(out)):
        some = ", ".join(earlier[:4]) + (" ..." if len(earlier) > 4 else "")
        what = "a render with the view" if len(earlier) == 1 else "a render with the views"
        said = f"{out} holds {what} {some}: this one takes its place"
        echo(f"note: {said}; another -o keeps both", err=True)


def _print_summary(summary: "RenderSummary") -> None:
    for name, view in summary.manifest["views"].items():
        width, height = view["resolution"]
        took = summary.timing["views"][name]
        echo(
            f"{name:<16} {width}x{height}  {_quality(view)}{took['render'] + took['output']:.1f} s"
        )
        for warning in _warnings(view, summary.manifest["stop"].get("error")):
            warn(f"{name}: {warning}")
    if losses := _losses(summary.manifest["report"]):
        echo(f"{losses}: see the report in {summary.out / 'manifest.json'}")
        for alarm in _alarms(summary.manifest["report"]):
            warn(alarm)
    echo(f"rendered with {summary.manifest['renderer']['backend']}")
    if summary.spares:
        spares = named([path.rpartition("/")[2] for path in summary.spares])
        echo(f"not drawn, since they are spare cameras: {spares}; --camera NAME draws one")
    for path in summary.stay:
        said = f"{path} stays: it is not a view of this run, and has files of others"
        echo(said, err=True)
    echo(f"wrote {summary.out / 'contact_sheet.png'} and manifest.json")


def _losses(report: Mapping[str, Any]) -> str:
    """What a picture lacks; collision shapes and the like, which are never seen, do not count."""
    from openrooms_usd.rendering.scene.unseen import is_aside

    told = Counter(row["outcome"] for row in report["losses"] if not is_aside(row["reason"]))
    return f"{told['approximated']} prims approximated, {told['skipped']} skipped" if told else ""


def _alarms(report: Mapping[str, Any]) -> Iterator[str]:
    """Likely mistakes of the stage: each once, with the first prim that has it."""
    from openrooms_usd.rendering.scene.unseen import is_alarming

    said = (
        (sentence, row["prim"])
        for row in report["losses"]
        for sentence in filter(is_alarming, row["reason"].split("; "))
    )
    found = list(gathered(said))
    for sentence, prims in found[: most(_MOST_ALARMS)]:
        yield f"{named(prims)}: {sentence}"
    if len(found) > most(_MOST_ALARMS):
        yield f"{len(found) - _MOST_ALARMS} more of this kind are in the report"


def _quality(view: Mapping[str, Any]) -> str:
    radiance = view["channels"].get("radiance")
    if radiance is None:
        return ""
    robust, squared = radiance["estimated_robust_error"], radiance["estimated_error"]
    measured = "" if robust is None else f", estimated error {robust:.2g}"
    measured += "" if squared is None else f" (relative MSE {squared:.2g})"
    return f"{radiance['samples']} samples{measured}  "


def _warnings(view: Mapping[str, Any], wanted: float | None) -> Iterator[str]:
    radiance = view["channels"].get("radiance")
    if radiance and wanted is not None:
        reached, samples = radiance["estimated_robust_error"], radiance["samples"]
        if reached is None:
            yield f"no estimated error after {samples} samples, so not surely {wanted:g}"
        elif reached > wanted:
            yield f"estimated error {reached:.2g} after {samples} samples, not {wanted:g}"
    for name, channel in view["channels"].items():
        if channel["nonfinite_pixels"]:
            yield f"{channel['nonfinite_pixels']} pixels of {name} were no finite numbers"
    if biased := [name for name, channel in view["channels"].items() if _is_biased(channel)]:
        total = view["channels"][biased[0]]["bias"]["total"]
        more = f", and others too ({len(biased) - 1})" if len(biased) > 1 else ""
        said = f"by {100 * total:+.1f} %{more}; --method reference has no bias"
        yield f"{biased[0]} is off {said}"


def _is_biased(channel: Mapping[str, Any]) -> bool:
    """Whether a channel is surely off by more than a picture may be."""
    bias: Mapping[str, float] | None = channel.get("bias")
    if bias is None:
        return False
    return abs(bias["total"]) - _SURE_STANDARD_ERRORS * bias["total_error"] > _BIAS_WORTH_A_WARNING


def film(stage: Path, out: Path, spec: str, settings: RenderSettings, **how: Any) -> None:
    """Render a path and say what came of it.

    Args:
        stage: The USD file.
        out: The folder.
        spec: The path, as `openrooms_usd.rendering.paths.rendering.render_path` takes it.
        settings: What is asked for.
        how: What else it takes.
    """
    from openrooms_usd.rendering.paths.rendering import render_path
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet(), progress_bar("translating") as progress:
        summary = render_path(stage, out, spec, settings, progress=progress, **how)
    print_result(summary.as_dict())
    told, spent = summary.manifest, sum(summary.timing.values())
    width, height = told["resolution"]
    echo(f"{len(told['frames'])} frames of {width}x{height}, {spent:.2f} s each")
    flickers = told["flicker"]
    if flickers["mean"] is not None:
        echo(f"flicker {flickers['mean']:.2g}, stated error {flickers['stated']:.2g} (relative)")
    echo(f"wrote {summary.video} and {summary.cameras.name}")
