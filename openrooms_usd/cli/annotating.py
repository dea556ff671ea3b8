"""The commands of ``annotate``: pages in which people correct a room."""

from typing import Final

import click

from openrooms_usd.cli.console import echo

# What ``labels`` needs, and no page has.
_OUT: Final = ("-o", "--out")


class _Commands(click.Group):
    """Goes on understanding ``annotate RENDER... -o FILE``, which is called ``labels`` now."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command."""
        if args[0] in self.commands or not any(word.startswith(_OUT) for word in args):
            return super().resolve_command(ctx, args)
        from openrooms_usd.cli.labelling import labels

        echo(
            "hint: this is `orusd labels` now; `orusd annotate` opens rooms in the browser",
            err=True,
        )
        return "labels", labels, args


@click.group(cls=_Commands, context_settings={"ignore_unknown_options": True})
def annotate() -> None:
    """Correct a room in the browser."""
