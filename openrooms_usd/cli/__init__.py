"""The command line: each command is imported when it is called, so that ``--help`` is instant."""

import gc
import sys
from importlib import import_module
from typing import Final

import click

from openrooms_usd.cli.command import Group, note_former
from openrooms_usd.cli.console import print_json, take_all_letters
from openrooms_usd.errors import OrusdError
from openrooms_usd.version import __version__

# section: command: (module, attribute, one line of help). The help stands here, because listing
# the commands must not import them.
_SECTIONS: Final = {
    "Getting started": {
        "demo": ("composing", "demo", "Compose and render the bundled example."),
        "init": ("describing", "init", "Write a small room.yaml to start from."),
        "doctor": ("describing", "doctor", "Say what this machine can do, and what it lacks."),
        "completion": ("describing", "completion", "Print what completes commands in a shell."),
    },
    "Rooms": {
        "import": ("importing", "import_", "Turn a capture into a room.yaml."),
        "generate": ("generating", "generate", "Write the room.yaml of a room from nothing."),
        "compose": ("composing", "compose", "Run the steps and stack their layers."),
        "edit": (
            "editing",
            "edit",
            "Correct a room in the browser; keep changes of other programs.",
        ),
        "appearance": ("appearing", "appearance", "Find materials and lights from photographs."),
        "simulate": ("simulating", "simulate", "Let a room settle under gravity."),
        "validate": ("validating", "validate", "Check a USD stage."),
    },
    "Rendering and light": {
        "render": ("rendering", "render", "Render the cameras of a USD stage with ground truth."),
        "relight": ("lighting", "relight", "Turn the lights of a finished render."),
        "probe": ("lighting", "probe", "Make light probes: panoramas and spherical harmonics."),
        "bake": ("baking", "bake", "Write the light as lightmaps, for real-time engines."),
        "compare": ("comparing", "compare", "Put renders beside the photographs of a capture."),
    },
    "Viewing and export": {
        "view": ("viewing", "view", "Look at a room in the browser."),
        "labels": ("labelling", "labels", "Write what a render shows as COCO or boxes."),
        "dataset": ("datasets", "dataset", "Make datasets: many rooms by one file, or of renders."),
        "convert": ("converting", "convert", "Write a USD stage in a foreign form."),
    },
    "Libraries and formats": {
        "library": ("libraries", "library", "Furniture: a list of it, or a picture."),
        "materials": ("materials", "materials", "Procedural materials: a list, or pictures."),
        "channels": ("channels", "channels", "Print the table of ground-truth channels."),
        "schema": ("describing", "schema", "Print the JSON Schema of room.yaml or dataset.yaml."),
    },
}
_COMMANDS: Final = {name: row for rows in _SECTIONS.values() for name, row in rows.items()}

# Commands that had other names, and those of `edit` that `annotate` had.
_FORMER: Final = {"annotate": "edit", "edits": "edit"}
_PAGES: Final = ("layout", "materials", "objects")

EXIT_CODES: Final = {
    0: "done",
    1: "errors were found (validate, verify), work failed, or something is lacking (doctor)",
    2: "a mistake in a description, a file that cannot be read, or an unknown option",
    3: "a file or folder cannot be written",
    4: "a USD stage is not what the command needs",
    5: "a renderer cannot do what is asked",
    6: "a package or a library is not installed",
    130: "interrupted; what was finished is kept",
}
"""What a command ends with."""

# New objects between two looks for cycles. At 700, looks at what was imported take a tenth.
_GARBAGE_THRESHOLD: Final = 20_000


class LazyGroup(Group):
    """A group that knows its commands by table and imports the one that is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names in the order of the table."""
        return list(_COMMANDS)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; ``annotate RENDER... -o FILE`` was one for labels."""
        has_out = any(word.startswith(("-o", "--out")) for word in args)
        if args[0] == "annotate" and has_out and args[1] not in _PAGES:
            note_former(ctx, args[0], "labels")
            args = ["labels", *args[1:]]
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one command."""
        if cmd_name not in _COMMANDS:
            return None
        module, attribute, _ = _COMMANDS[cmd_name]
        command = getattr(import_module(f"{__name__}.{module}"), attribute)
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands from the table alone."""
        for title, rows in _SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl([(name, row[2]) for name, row in rows.items()])

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options and the example, then the exit codes."""
        super().format_options(ctx, formatter)
        with formatter.section("Exit codes"):
            formatter.write_dl([(str(code), text) for code, text in EXIT_CODES.items()])


@click.group(
    cls=LazyGroup,
    example="orusd demo",
    former=_FORMER,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(__version__, prog_name="orusd")
def orusd() -> None:
    """Indoor scenes from one text file: USD layers, pictures and ground truth."""


def main() -> None:
    """Run the command line; errors for people become one message and an exit code."""
    from openrooms_usd.cli.interruption import leave, prompt_interrupts

    take_all_letters()
    gc.set_threshold(_GARBAGE_THRESHOLD, *gc.get_threshold()[1:])
    try:
        with prompt_interrupts():
            orusd(standalone_mode=False)
    except OrusdError as error:
        _print_error(error.as_dict())
        click.echo(f"error: {error}", err=True)
        sys.exit(error.exit_code)
    except click.ClickException as error:
        _print_error(OrusdError(error.format_message()).as_dict() | {"code": "usage"})
        error.show()
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        leave()


def _print_error(error: dict[str, str | None]) -> None:
    """With ``--json`` there is a document of errors too; the options may not have been read."""
    if "--json" in sys.argv:
        print_json({"error": error})
