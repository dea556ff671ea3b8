"""Writes the generated pages of docs/reference: ``python -m docs.reference_pages``."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

from docs import reference_commands, reference_errors, reference_fields

FOLDER: Final = Path(__file__).with_name("reference")
PAGES: Final[dict[str, Callable[[], str]]] = {
    "cli.md": reference_commands.page,
    "room-yaml.md": reference_fields.room_page,
    "dataset-yaml.md": reference_fields.dataset_page,
    "errors.md": reference_errors.page,
}
"""What makes each page."""

if __name__ == "__main__":
    for name, page in PAGES.items():
        (FOLDER / name).write_text(page(), encoding="utf-8")
