from collections.abc import Callable
from typing import Any

import pytest


def said(error: type[Exception], call: Callable[..., object], *arguments: Any, **named: Any) -> str:
    """Return the sentence of the error that a call raises."""
    with pytest.raises(error) as caught:
        call(*arguments, **named)
    return str(caught.value)
