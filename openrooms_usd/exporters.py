"""The contract of exporters, and the report of what became of every prim."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, Protocol

from openrooms_usd import adapters
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, nested, passed_to, silent
from openrooms_usd.untrusted import check_path

if TYPE_CHECKING:
    from pxr import Usd

Outcome = Literal["translated", "approximated", "skipped"]

# A matrix as plain data.
Rows = tuple[tuple[float, ...], ...]
_SAME: Final[Rows] = tuple(tuple(float(row == column) for column in range(4)) for row in range(4))

# The default format of a file by its ending, and of a folder.
_BY_ENDING: Final = {".glb": "gltf", ".usdz": "usdz", ".xml": "mitsuba", "": "mitsuba"}
# The share of opening a stage in the time that it takes to convert it.
_OPENED: Final = 0.1
# Of files: a folder may be called room_1.5.
_ENDING: Final = re.compile(r"\.[a-z][a-z0-9]*")


@dataclass
class Report:
    """What became of every prim of a stage: nothing is lost in silence.

    Attributes:
        rows: (prim path, outcome, reason); the reason is empty for what was translated whole.
        world_from_stage: (4, 4) by rows, from the stage's coordinates to the scene's: metres, Z up.
    """

    rows: list[tuple[str, Outcome, str]] = field(default_factory=list)
    world_from_stage: Rows = _SAME

    def add(self, prim: object, outcome: Outcome, reason: str = "") -> None:
        """Say what became of a prim."""
        self.rows.append((str(prim), outcome, reason))

    def say(self, prim: object, losses: Iterable[str]) -> None:
        """Say that a prim was translated: whole, or approximated for these reasons."""
        reason = "; ".join(dict.fromkeys(losses))
        self.add(prim, "approximated" if reason else "translated", reason)

    def lose(self, reasons: Mapping[str, str]) -> None:
        """Say what was lost of prims later on; those with an empty reason stay as they are.

        Args:
            reasons: By prim path; a prim without a row gets one.
        """
        left = dict(reasons)
        for number in reversed(range(len(self.rows))):
            prim, outcome, reason = self.rows[number]
            # Of several rows of a prim the last one: the others tell of its parts.
            if later := left.pop(prim, ""):
                # What was skipped is not there to lose anything.
                found: Outcome = "skipped" if outcome == "skipped" else "approximated"
                self.rows[number] = prim, found, "; ".join(filter(None, (reason, later)))
        self.rows += [(prim, "approximated", reason) for prim, reason in left.items() if reason]

    def gather(self) -> None:
        """Make one row of all that say the same of a prim, with all their reasons."""
        said: dict[tuple[str, Outcome], dict[str, None]] = {}
        for prim, outcome, reason in self.rows:
            said.setdefault((prim, outcome), {}).update(dict.fromkeys(filter(None, [reason])))
        self.rows = [(*key, "; ".join(reasons)) for key, reasons in said.items()]

    def count(self, outcome: Outcome) -> int:
        """How many rows have this outcome."""
        return sum(1 for _, found, _ in self.rows if found == outcome)

    def losses(self) -> Iterator[tuple[str, Outcome, str]]:
        """The rows that were not translated whole."""
        return (row for row in self.rows if row[1] != "translated")

    def __repr__(self) -> str:
        kinds: tuple[Outcome, ...] = ("translated", "approximated", "skipped")
        return f"Report({', '.join(f'{self.count(kind)} {kind}' for kind in kinds)})"

    def whole(self) -> dict[str, object]:
        """Every row and the frame as plain data."""
        entries = [
            {"prim": prim, "outcome": outcome, "reason": reason}
            for prim, outcome, reason in self.rows
        ]
        return {"entries": entries, "world_from_stage": self.world_from_stage}

    def as_dict(self) -> dict[str, object]:
        """The counts and the losses as plain data."""
        return {
            "translated": self.count("translated"),
            "approximated": self.count("approximated"),
            "skipped": self.count("skipped"),
            "losses": [
                {"prim": prim, "outcome": outcome, "reason": reason}
                for prim, outcome, reason in self.losses()
            ],
        }


class Exporter(Protocol):
    """Writes a stage in a foreign form; an entry point ``openrooms_usd.exporters``.

    One that copies layers as they are has an attribute ``keeps_layers``, which is true. One that
    says in an attribute ``writes`` how its destinations end, such as ``(".glb",)``, gets no others;
    a folder ends in nothing. One whose ``convert`` takes a `openrooms_usd.progress.Progress` as
    ``progress`` says by it how far it is.
    """

    def convert(self, stage: "Usd.Stage", destination: Path, options: Mapping[str, Any]) -> Report:
        """Write ``stage`` to ``destination``.

        Raises:
            OutputError: The destination cannot be written.
        """
        ...


def convert_stage(
    path: Path,
    destination: Path,
    *,
    to: str | None = None,
    options: Mapping[str, Any] | None = None,
    include_outside: bool = False,
    time_code: float | None = None,
    progress: Progress = silent,
) -> Report:
    """Write a stage in a foreign form, as `openrooms_usd.api.scenes.convert` describes.

    An exporter that copies layers copies files from outside only with ``include_outside``, and
    writes all times if ``time_code`` is None.
    """
    from openrooms_usd.usd.files.diagnostics import reading
    from openrooms_usd.usd.files.layers import open_stage
    from openrooms_usd.usd.outside import is_picture, refuse_outside

    kind = to or exporter_of(destination)
    exporter: Exporter = adapters.load(adapters.EXPORTERS, kind)
    _check_ending(exporter, kind, destination)
    keeps_layers = getattr(exporter, "keeps_layers", False)
    if keeps_layers and time_code is not None:
        raise InputError(
            "this exporter copies the stage's layers with all that moves",
            place="time code",
            remedy="omit it, or convert to a format that holds one moment",
        )
    stage = open_stage(path)
    if not include_outside:
        concerns = (lambda _: True) if keeps_layers else is_picture
        refuse_outside(stage, str(destination), concerns)
    inner = nested(progress, "", _OPENED, 1.0)
    with reading(path):
        return write_stage(stage, destination, kind, options, time_code=time_code, progress=inner)


def write_stage(
    stage: "Usd.Stage",
    destination: Path,
    to: str,
    options: Mapping[str, Any] | None = None,
    *,
    time_code: float | None = None,
    progress: Progress = silent,
) -> Report:
    """Write an open stage in a foreign form, wherever its files lie.

    Args:
        stage: The composed stage.
        destination: The file or folder to write.
        to: The exporter's name.
        options: What the exporter understands.
        time_code: The moment to write, as in `convert_stage`.
        progress: Called with what the exporter works on, where it says so.

    Returns:
        What became of every prim.

    Raises:
        InputError: No exporter has that name.
        StageError: It is not what the exporter needs.
        OutputError: The destination cannot be written.
    """
    from openrooms_usd.usd.moments import freeze_time
    from openrooms_usd.usd.shading.mtlxlayers import read_mtlx_layers

    exporter: Exporter = adapters.load(adapters.EXPORTERS, to)
    lost: dict[str, str] = {}
    if not getattr(exporter, "keeps_layers", False):
        read_mtlx_layers(stage)
        lost = freeze_time(stage, time_code)
    how = passed_to(exporter.convert, progress)
    report = exporter.convert(stage, destination, options or {}, **how)
    report.lose(lost)
    add_composition_errors(report, stage)
    return report


def exporter_of(destination: Path) -> str:
    """The exporter that a destination asks for by its ending.

    Raises:
        InputError: No file ends so.
    """
    ending = _ending(destination)
    if ending not in _BY_ENDING:
        raise InputError(
            f"no exporter writes {ending} files",
            place=destination,
            remedy=f"end it in {', '.join(filter(None, _BY_ENDING))}, or name a folder and give "
            f"--to: {', '.join(adapters.available(adapters.EXPORTERS))}",
        )
    return _BY_ENDING[ending]


def _ending(destination: Path) -> str:
    """How the name of a file ends; empty of a folder."""
    check_path(destination)
    ending = destination.suffix.lower()
    return "" if destination.is_dir() or not _ENDING.fullmatch(ending) else ending


def _check_ending(exporter: Exporter, kind: str, destination: Path) -> None:
    """Refuse a file where a folder is written, and the other way round."""
    wanted = getattr(exporter, "writes", None)
    if wanted is None or _ending(destination) in wanted:
        return
    what = " or ".join(f"a file that ends in {one}" if one else "a folder" for one in wanted)
    raise InputError(
        f"the exporter {kind} writes {what}", place=destination, remedy="give another name"
    )


def add_composition_errors(report: Report, stage: "Usd.Stage") -> None:
    """Report what no prim tells of: what USD cannot find, and the frame that all is moved to."""
    from openrooms_usd.usd.files.diagnostics import composition_errors
    from openrooms_usd.usd.places.frames import world_from_stage

    for prim, reason in composition_errors(stage):
        report.add(prim, "skipped", reason)
    report.world_from_stage = tuple(map(tuple, world_from_stage(stage).tolist()))
