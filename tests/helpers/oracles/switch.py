from collections.abc import Callable
from typing import Any

from oracles.worlds import Moment


def switched(rules: dict[str, Callable[..., Any]]) -> Callable[..., Any]:
    """The first case that holds decides."""

    def decide(now: Moment, told: Any, *, cases: Any) -> Any:
        for case in cases:
            in_time = case.before_s is None or now.now_s < case.before_s
            if in_time and (case.backlog_below is None or len(now.backlog) < case.backlog_below):
                return rules[case.rule](now, told)
        raise AssertionError("the last case holds always")

    return decide


def next_case(now: Moment, told: Any, *, cases: Any) -> float | None:
    return min((case.before_s for case in cases if (case.before_s or 0) > now.now_s), default=None)
