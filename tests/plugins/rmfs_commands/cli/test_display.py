"""What displays have in common."""

import pytest

from rmfs_commands.cli.display import duration


@pytest.mark.parametrize(("seconds", "text"), [(0, "0:00:00"), (3599.6, "1:00:00"), (36_061, "10:01:01")])
def test_durations(seconds: float, text: str) -> None:
    """Hours, minutes and seconds, rounded."""
    assert duration(seconds) == text
