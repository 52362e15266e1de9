from typing import Any

import pytest


def cases(names: str, *rows: Any, **options: Any) -> pytest.MarkDecorator:
    """Let a test run with each row of values; the names of its parameters stand in one text with blanks between."""
    return pytest.mark.parametrize(names.replace(" ", ","), rows, **options)
