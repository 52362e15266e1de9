from collections.abc import Callable
from typing import Any

import pytest

from rmfs_commands.cli.main import main
from rmfs_core.errors import InputError


def exit_code(*arguments: str) -> int:
    """Run ``rmfs`` and return how it exits."""
    try:
        main(list(arguments))
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def refused(capsys: pytest.CaptureFixture[str], call: Callable[..., object], *arguments: Any, **named: Any) -> str:
    """Return the standard error of a call that ends with exit code 2 and prints nothing else."""
    capsys.readouterr()
    with pytest.raises(SystemExit) as stop:
        call(*arguments, **named)
    out, err = capsys.readouterr()
    assert (stop.value.code, out) == (2, "")
    return err


def refusal(call: Callable[[], object]) -> str:
    """Return the sentence with which an input is refused."""
    with pytest.raises(InputError) as caught:
        call()
    return str(caught.value)
