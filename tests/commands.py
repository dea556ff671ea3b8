"""The command line in this process."""

from click.testing import CliRunner, Result

from openrooms_usd.cli import orusd


def run(*words: object) -> Result:
    """What ``orusd WORDS`` says, and what it ended with."""
    return CliRunner().invoke(orusd, [*map(str, words)])


def output_of(*words: object) -> str:
    """What a command says that succeeds; what it raises is raised."""
    done = CliRunner().invoke(orusd, [*map(str, words)], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output
