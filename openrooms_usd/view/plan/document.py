"""The ``room.yaml`` of a plan: what it says, what compose says of it, and a draft beside it."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from openrooms_usd import atomic, removal
from openrooms_usd.description import load_room, parse_room
from openrooms_usd.description.generate import GeneratedLayout
from openrooms_usd.description.layout import CapturedLayout, PolygonLayout
from openrooms_usd.description.mistakes import FieldsError
from openrooms_usd.description.rewriting import rewritten
from openrooms_usd.description.room import Room, refused_fields
from openrooms_usd.errors import DescriptionError, OrusdError, OutputError
from openrooms_usd.steps.layout.step import described_plan, plan_of
from openrooms_usd.untrusted import read_bytes, read_text
from openrooms_usd.view.plan.drawing import Drawing
from openrooms_usd.view.plan.underlay import Underlay, first_drawing, underlay_of, walls_of_a_seed

SECTION: Final = "layout"
_REMEDY: Final = "`orusd import` makes one of a capture"


class Document:
    """A ``room.yaml`` that is being changed.

    Attributes:
        file: Where it is.
        draft: Where what is not saved yet is kept.
        text: What stands in it, as far as we know.
        saved: The plan that this says, or that was found where it says none.
        under: What was captured.

    Args:
        file: An existing ``room.yaml``.

    Raises:
        DescriptionError: It is not a valid description.
        InputError: It, or its capture, cannot be read.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self.draft = file.with_name(f".{file.stem}.draft.json")
        self.under: Underlay = underlay_of(load_room(file), file.parent)
        self.text = self._read()
        self.saved = self._drawing(self.text)

    def _read(self) -> str:
        return read_bytes(self.file, "description", remedy=_REMEDY).decode()

    def _layout(self, text: str) -> PolygonLayout | CapturedLayout:
        layout = self._room(text).layout
        if isinstance(layout, GeneratedLayout):
            raise walls_of_a_seed()
        return layout

    def _room(self, text: str) -> Room:
        return parse_room(text, str(self.file), folder=self.file.parent)

    def _drawing(self, text: str) -> Drawing:
        return first_drawing(self._layout(text), self.under)

    def has(self, plan: Drawing) -> bool:
        """Whether the file says that plan, or leaves it as it was found."""
        return plan.as_section() == self.saved.as_section()

    def renumbers(self, plan: Drawing) -> bool:
        """Whether the file names walls by numbers that are others' in that plan."""
        if len(plan.corners) == len(self.saved.corners):
            return False
        room = parse_room(self.text, str(self.file))
        cladding = self._layout(self.text).cladding
        accents = room.materials.accents
        return any(one.walls for one in cladding) or any(
            name.startswith("wall_") for name in accents
        )

    def text_of(self, plan: Drawing) -> str:
        """The text with a plan in it; as it stands, where it has that plan already.

        Raises:
            DescriptionError: The section is so written that no part of it can be changed.
        """
        if self.has(plan):
            return self.text
        before, section = self.saved.as_section(), plan.as_section()
        # What is said already, and has not changed, stays as it is written.
        drawn = self._layout(self.text).polygon is not None
        changed = {k: v for k, v in section.items() if not drawn or v != before[k]}
        text = rewritten(self.text, SECTION, changed, str(self.file))
        # What is left to defaults, such as the middle of a wall, may mean another thing now.
        same = self._reads_as(text, section)
        return text if same else rewritten(self.text, SECTION, section, str(self.file))

    def _reads_as(self, text: str, section: Mapping[str, Any]) -> bool:
        try:
            return self._drawing(text).as_section() == section
        except DescriptionError:
            return True

    def refusal(self, plan: Drawing) -> OrusdError | None:
        """What compose would say against a room of that plan; None where it would take it."""
        try:
            self.check(self.text_of(plan))
        except OrusdError as error:
            return error
        return None

    def check(self, text: str) -> None:
        """Refuse what compose would refuse, in its words.

        Raises:
            DescriptionError: It is not a valid description, or something does not fit.
        """
        layout = self._layout(text)
        try:
            if isinstance(layout, PolygonLayout):
                described_plan(layout, [])
            else:
                assert self.under.capture is not None, "it was read"
                plan_of(layout, self.under.capture, self.file.parent, [])
        except FieldsError as error:
            raise refused_fields(self._room(text), error.found) from None

    def save(self, plan: Drawing) -> None:
        """Write a plan into the file, and forget the draft.

        Raises:
            DescriptionError: Compose would refuse it; nothing is written.
            OutputError: Another program has changed the file, or it cannot be written.
        """
        if self._read() != self.text:
            raise OutputError(
                "another program has changed the file",
                place=self.file,
                remedy="check its plan, which is shown now, or undo it to continue with yours",
            )
        text = self.text_of(plan)
        self.check(text)
        if text != self.text:
            atomic.write_bytes(self.file, text.encode())
        self.text, self.saved = text, self._drawing(text)
        self.forget()

    def changed(self) -> Drawing | None:
        """Read the file again; the plan, where another program gave it another one.

        Raises:
            DescriptionError: It is not a valid description now; the previous text is kept.
        """
        text = self._read()
        if text == self.text:
            return None
        before, after = self.saved, self._drawing(text)
        self.text, self.saved = text, after
        return None if after.as_section() == before.as_section() else after

    def keep(self, plan: Drawing) -> None:
        """Keep a plan that is not saved yet beside the file; none where the file has it."""
        if self.has(plan):
            self.forget()
            return
        text = json.dumps({SECTION: plan.as_section()}, indent=1) + "\n"
        atomic.write_text(self.draft, text)

    def kept(self) -> Drawing | None:
        """The plan that was kept before and is not in the file; None where there is none."""
        if not self.draft.is_file():
            return None
        try:
            section: Any = json.loads(read_text(self.draft))[SECTION]
            text = rewritten(self.text, SECTION, section, str(self.file))
            plan = self._drawing(text)
        except (ValueError, KeyError, TypeError, AttributeError, DescriptionError):
            return None
        return None if self.has(plan) else plan

    def forget(self) -> None:
        """Remove the draft."""
        removal.remove_file(self.draft)
