"""`tiloilc demos`: demonstrations are recorded, looked at, and converted."""

import typer

from tiloilc.cli.demos import check, convert, record

__all__ = ["group"]

group = typer.Typer(
    rich_markup_mode=None,
    no_args_is_help=True,
    help="Record demonstrations, run them through the automaton, convert them.",
)
group.command("record")(record.command)
group.command("check")(check.command)
group.command("convert")(convert.command)
