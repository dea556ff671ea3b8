"""From a description to a composed stage: run the steps, stack their layers, flatten, package."""

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, Literal

from openrooms_usd import atomic, claims, names
from openrooms_usd.description.former import note_of
from openrooms_usd.description.generate import GeneratedFurniture, GeneratedLayout
from openrooms_usd.description.mistakes import FieldsError
from openrooms_usd.description.room import Room, refused_fields
from openrooms_usd.edits.fitting import misfits_of
from openrooms_usd.edits.foreign import refuse_foreign
from openrooms_usd.edits.orphans import Orphan, orphans_of
from openrooms_usd.errors import InputError, OutputError, StageError, printable
from openrooms_usd.progress import Progress, nested, silent
from openrooms_usd.spelling import did_you_mean
from openrooms_usd.steps import base, checks, runner
from openrooms_usd.steps.draft import Draft, drafting
from openrooms_usd.steps.reports import OVERLAY, REPORT, gather

State = Literal["written", "unchanged"]

_FLAT: Final = ".usdc"
_PACKED: Final = ".usdz"
# What decides where things come to rest.
_SETTLING: Final = ("layout", "alignment", "physics")


@dataclass(frozen=True)
class StepSummary:
    """What became of one step."""

    stage: str
    state: State
    seconds: float
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class ComposeSummary:
    """What a composition did.

    Attributes:
        scene: The root layer.
        stages: From the weakest to the strongest layer.
        files: The flattened and packaged files that were asked for.
        orphans: Opinions of the edits that do nothing.
        notes: Sentences about the room as a whole.
    """

    scene: Path
    stages: tuple[StepSummary, ...]
    files: tuple[Path, ...] = ()
    orphans: tuple[Orphan, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def unchanged(self) -> bool:
        """Whether every step was up to date."""
        return all(summary.state == "unchanged" for summary in self.stages)

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {
            "scene": str(self.scene),
            "stages": [asdict(summary) for summary in self.stages],
            "files": [str(path) for path in self.files],
            "orphans": [asdict(orphan) for orphan in self.orphans],
            "notes": list(self.notes),
        }


def compose_room(
    description: Room | Path,
    out: Path,
    *,
    base: Path | None = None,
    only: str | None = None,
    flatten: bool = False,
    usdz: bool = False,
    include_outside: bool = False,
    workers: int | None = None,
    progress: Progress = silent,
) -> ComposeSummary:
    """Compose a room: `openrooms_usd.api.scenes.compose` has the arguments and the errors.

    Steps whose inputs have not changed since their layer was written are skipped.
    """
    described, source = checks.checked(description, base)
    room, about_clutter = _explicit(described.located(source))
    chosen = _chosen(only)
    if printable(out.absolute(), lines=False) != str(out.absolute()):
        raise OutputError(
            "USD cannot read from a folder with control characters in its name",
            place=out.absolute(),
            remedy="choose another output folder",
        )
    with claims.claimed(out):
        refuse_foreign(out / names.SCENE)
        extra = _extra_files(out / names.SCENE, flatten, usdz)
        atomic.check_free((*extra, *(out / name for name in (REPORT, OVERLAY))))
        with drafting(out) as draft:
            _check_complete(draft, chosen)
            runner.create_edits(draft)
            summaries = []
            for index, step in enumerate(chosen):
                begin, end = index / len(chosen), (index + 1) / len(chosen)
                share = nested(progress, names.section_of(step.name), begin, end)
                try:
                    summaries.append(_run(step, room, source, draft, workers, share))
                except FieldsError as error:
                    raise refused_fields(described, error.found) from None
            noted = None
            if any(summary.state == "written" for summary in summaries):
                from openrooms_usd.validation.model import Subject
                from openrooms_usd.validation.room_rules import findings_of

                noted = tuple(findings_of(Subject(runner.check(draft))))
            runner.write_scene(draft, noted)
        files = (*gather(out), *_extras(out / names.SCENE, flatten, usdz, include_outside))
        orphans = orphans_of(out)
        misfits = misfits_of(out)
    notes = (
        *_about_names(described, only),
        *about_clutter,
        *_about_settled(out, summaries),
        *runner.notes_of(out / names.SCENE),
        *_about_strangers(out, draft),
        *(f"{misfit}: see orusd edit fix-units" for misfit in misfits),
    )
    return ComposeSummary(out / names.SCENE, tuple(summaries), files, orphans, notes)


def _about_names(room: Room, only: str | None) -> Iterator[str]:
    """Notes on former names, each once."""
    former = [note_of(only)] if only in names.FORMER_SECTIONS else []
    yield from dict.fromkeys((*room.notes, *former))


def _about_settled(out: Path, summaries: Sequence[StepSummary]) -> Iterator[str]:
    """What is to be said of the poses of a simulation, which compose neither writes nor drops."""
    layer = f"{names.LAYERS}/{names.SETTLED}.usda"
    if not (out / layer).is_file():
        return
    again = "run orusd simulate again, or remove it"
    again_made = (row.stage for row in summaries if row.state == "written")
    changed = [names.section_of(step) for step in again_made if step in _SETTLING]
    if changed:
        yield f"{layer} is older than the {' and the '.join(changed)}: {again}"
    gone = orphans_of(out, names.SETTLED)
    if gone:
        yield f"{layer} has {len(gone)} opinions without effect, the first: {gone[0]}: {again}"


def _about_strangers(out: Path, draft: Draft) -> Iterator[str]:
    """What lies among the files of a step and is not ours to remove."""
    if draft.stay:
        first = draft.stay[0].relative_to(out.absolute()).as_posix()
        more = f" and {len(draft.stay) - 1} more stay" if len(draft.stay) > 1 else " stays"
        yield f"{first}{more}: no layer refers to it, and compose did not write it as it is now"


def _explicit(room: Room) -> tuple[Room, tuple[str, ...]]:
    """The room with what is to be drawn spelled out, and what is to be said of that.

    The generator is imported only then.
    """
    generated = isinstance(room.layout, GeneratedLayout)
    if not generated and not isinstance(room.furniture, GeneratedFurniture) and not room.clutter:
        return room, ()
    from openrooms_usd.generation import expanded

    explicit = expanded(room)
    before, after = (len(getattr(one.furniture, "objects", ())) for one in (room, explicit))
    nothing = (
        "clutter: none was placed, because no surface has space for it; add a table or a shelf"
    )
    return explicit, (nothing,) if room.clutter and before == after else ()


def _run(
    step: base.Step, room: Room, source: Path, draft: Draft, workers: int | None, progress: Progress
) -> StepSummary:
    """Run a step, unless its layer is up to date."""
    started = time.perf_counter()
    progress("", 0.0)
    wanted = base.fingerprint(step, room, source, draft.layer)
    state: State = "unchanged"
    if runner.is_current(step, wanted, draft):
        notes: Sequence[str] = runner.notes_of(draft.layer(step.name), step.name)
    else:
        state = "written"
        threads = workers or os.cpu_count() or 1
        notes = runner.run(step, room, source, draft, wanted, threads, progress)
    progress("", 1.0)
    return StepSummary(step.name, state, time.perf_counter() - started, tuple(notes))


def _chosen(only: str | None) -> list[base.Step]:
    steps = runner.steps()
    if only is None:
        return steps
    chosen = [step for step in steps if names.section_of(step.name) == names.section_of(only)]
    if not chosen:
        known = [names.section_of(step.name) for step in steps]
        raise InputError(
            f"no step is named {only!r}{did_you_mean(only, known)}",
            remedy=f"steps: {', '.join(known)}",
        )
    return chosen


def _check_complete(draft: Draft, chosen: Sequence[base.Step]) -> None:
    """Refuse steps whose weaker layers are neither there nor written before them."""
    known = {step.name for step in chosen}
    for step in chosen:
        missing = [n for n in step.reads if n not in known and not draft.layer(n).is_file()]
        if missing:
            raise StageError(
                f"{step.name} reads the layer {missing[0]}, which does not exist yet",
                place=draft.layer(missing[0]),
                remedy="compose the whole room once, without naming one step",
            )


def _extra_files(scene: Path, flatten: bool, usdz: bool) -> tuple[Path, ...]:
    asked = {_FLAT: flatten, _PACKED: usdz}
    return tuple(scene.with_suffix(suffix) for suffix in asked if asked[suffix])


def _extras(scene: Path, flatten: bool, usdz: bool, include_outside: bool) -> tuple[Path, ...]:
    from openrooms_usd import package

    files = _extra_files(scene, flatten, usdz)
    for file in files:
        write = package.flatten if file.suffix == _FLAT else package.package
        write(scene, file, include_outside=include_outside)
    return files
