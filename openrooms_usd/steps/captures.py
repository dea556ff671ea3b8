"""The capture of a section: read by its importer, and all files that this reads."""

from collections.abc import Iterator
from pathlib import Path

from openrooms_usd import adapters
from openrooms_usd.capture import Capture, option_paths, read_capture
from openrooms_usd.description.room import Room
from openrooms_usd.description.scanned import CapturedSection
from openrooms_usd.library.models.meshfile import dependencies
from openrooms_usd.portable import relative_text
from openrooms_usd.steps.base import StepContext, input_file
from openrooms_usd.untrusted import check_path


def captured_section(room: Room) -> CapturedSection | None:
    """The section that names the room's capture: the layout before the furniture."""
    sections = (room.layout, room.furniture)
    return next((section for section in sections if isinstance(section, CapturedSection)), None)


def capture_of(context: StepContext, section: CapturedSection) -> Capture:
    """Read the capture of a section.

    Raises:
        InputError: It cannot be read, or there is no such importer or option.
    """
    path = capture_path(context, section)
    return read_capture(section.reader, path, section.asked, context.source)


def capture_path(context: StepContext, section: CapturedSection) -> Path:
    """The file or folder that a section's capture is read from.

    Raises:
        InputError: It does not exist, or cannot be looked at.
    """
    return input_file(context.source, section.file, folders=True)


def capture_inputs(section: CapturedSection, source: Path) -> list[str]:
    """The files that the capture of a section is read from, relative to the description.

    Args:
        section: The section.
        source: The description's folder.
    """
    own = _below(source, section.file) if _is_folder(source, section.file) else [section.file]
    return list(dict.fromkeys([*own, *_named(section, source)]))


def _is_folder(source: Path, relative: str) -> bool:
    check_path(source / relative)
    return (source / relative).is_dir()


def _below(source: Path, folder: str) -> list[str]:
    files = (path for path in (source / folder).rglob("*") if path.is_file())
    return sorted(path.relative_to(source).as_posix() for path in files)


def _named(section: CapturedSection, source: Path) -> Iterator[str]:
    """What the options name: files, and of folders the models that the capture finds in them."""
    if not section.asked:
        return
    paths = option_paths(adapters.load(adapters.IMPORTERS, section.reader))
    named = [value for name, value in section.asked.items() if name in paths]
    yield from (value for value in named if not _is_folder(source, value))
    if any(_is_folder(source, value) for value in named):
        capture = read_capture(section.reader, source / section.file, section.asked, source)
        for file in sorted({model.file for model in capture.models if model.file}):
            for path in (file.resolve(), *dependencies(file)):
                yield relative_text(path, source.resolve())
