"""Arrays that grow."""

from __future__ import annotations

from rmfs_pod_index.period import NONE, OF_LINES, OF_ORDERS, PACKED, Period, new_period, with_room


def test_what_is_there_is_kept_when_more_room_is_needed() -> None:
    """And what has room stays the same object."""
    period = with_room(new_period(3, 2, 1, 4), OF_LINES, 2)
    period.sku[:2] = 1, 2
    assert with_room(period, OF_LINES, 2) is period
    grown = with_room(period, OF_LINES, 1000)
    assert grown.sku[:2].tolist() == [1, 2]
    assert len(grown.takes) >= 1000
    assert grown.items is period.items


def test_nothing_is_there_at_first() -> None:
    """No line, no pod bound anywhere; and all that grows is named."""
    period = new_period(3, 2, 1, 4)
    assert (period.head.tolist(), period.last.tolist()) == ([NONE] * 3, [NONE] * 2)
    assert period.available.shape == (3, 1)
    assert {name for name in Period._fields if not len(getattr(period, name))} == {
        *OF_LINES, *OF_ORDERS, *PACKED, "placed", "least"
    }  # fmt: skip
