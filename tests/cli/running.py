"""Runs the command line inside the test's own process."""

from collections.abc import Callable

import pytest

from tiloilc.cli import main

Run = Callable[..., tuple[int, str, str]]
"""Arguments to exit status, standard output, standard error."""


def runner(capsys: pytest.CaptureFixture[str]) -> Run:
    """The command line as a function."""

    def call(*arguments: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as caught:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert isinstance(caught.value.code, int)
        return caught.value.code, out, err

    return call
