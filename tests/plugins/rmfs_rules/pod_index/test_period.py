"""Arrays that grow, and lie in one."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rmfs_rules.pod_index
from rmfs_rules.pod_index.period import NONE, OF_LINES, Account, Period, new_account


@pytest.fixture
def account() -> Account:
    """Two pods, of which the second has two of three SKUs, and one station."""
    return new_account(np.array([0, 1, 1]), np.array([1, 0, 1]), 2, 3, np.zeros((1, 4), np.int64))


def test_what_is_there_is_kept_when_more_room_is_needed(account: Account) -> None:
    """And what has room stays the same object."""
    account.make_room(dict.fromkeys(OF_LINES, 2))
    account.period.lines["sku"][:2] = 1, 2
    account.period.entries["free"] = 7
    before = account.period
    account.make_room(dict.fromkeys(OF_LINES, 2))
    assert account.period is before
    account.make_room({"lines": 10_000})
    assert account.period.lines["sku"][:2].tolist() == [1, 2]
    assert len(account.period.lines) >= 10_000
    assert account.period.entries.tolist() == before.entries.tolist()
    assert len(account.period.orders) == len(before.orders)


def test_nothing_is_there_at_first(account: Account) -> None:
    """No line, no pod bound anywhere; and all that grows is named."""
    period = account.period
    assert (period.skus["head"].tolist(), period.pods["last"].tolist()) == ([NONE] * 3, [NONE] * 2)
    assert period.available.shape == (3, 1)
    assert {name for name in Period.__annotations__ if not len(getattr(period, name))} == {*OF_LINES, "placed"}


def test_what_pods_have_is_found_by_pod_and_by_sku(account: Account) -> None:
    """SKU 0 is on pod 1, SKU 1 on both, SKU 2 on none; each entry knows where it is among those of its SKU."""
    period = account.period
    assert (period.first.tolist(), period.first_with.tolist()) == ([0, 1, 3], [0, 1, 3, 3])
    assert period.holders["pod"].tolist() == [1, 0, 1]
    assert period.entries["holder"].tolist() == [1, 0, 2]


def test_no_array_lies_on_another(account: Account) -> None:
    """Each is written to in turn, and no other changes."""
    account.make_room(dict.fromkeys(OF_LINES, 3))
    arrays = [array for array in account.period[:-2] if array.size]
    for array in arrays:
        before = [other.tobytes() for other in arrays if other is not array]
        array.view(np.int64)[...] = 1 + array.view(np.int64)
        assert [other.tobytes() for other in arrays if other is not array] == before


def test_an_account_of_the_same_pods_has_no_lines(account: Account) -> None:
    """What filters have left is put into it."""
    account.make_room(dict.fromkeys(OF_LINES, 3))
    account.period.entries["free"], account.period.skus["head"], account.period.pods["cell"] = 5, 0, 3
    account.period.available[:] = 4
    other = account.without_lines().period
    assert other.entries.tolist() == account.period.entries.tolist()
    assert (other.pods["cell"].tolist(), other.skus["head"].tolist()) == ([3, 3], [NONE] * 3)
    assert other.available.tolist() == [[4]] * 3
    assert not other.lines.size


NEXT = """
import numpy as np
from rmfs_rules.pod_index.period import new_account
from rmfs_rules.pod_index.urging import next_urgent
zero = np.zeros(1, np.int64)
account = new_account(zero, zero, 1, 1, np.zeros((1, 1), np.int64))
account.period.ages["lines_of"], account.period.ages["arrivals_of"] = 2, 6
print(next_urgent(*account.parts, 10, 60), sum(next_urgent.stats.cache_hits.values()))
"""


def test_another_layout_of_records_is_compiled_anew(tmp_path: Path) -> None:
    """Where it is in another file than the code that numba has kept: that would read other fields."""
    folder, copy = Path(rmfs_rules.__file__).parent, tmp_path / "rmfs_rules"
    period = copy / "pod_index" / "period.py"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("__pycache__"))
    variables = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}

    def told() -> str:
        command = [sys.executable, "-c", NEXT]
        return subprocess.run(command, env=variables, capture_output=True, text=True, check=True).stdout

    assert (told(), told()) == ("33 0\n", "33 1\n")
    code = period.read_text(encoding="utf-8")
    other = code.replace('_record("lines_of arrivals_of")', '_record("arrivals_of lines_of")')
    assert other != code
    period.write_text(other, encoding="utf-8")
    assert told() == "33 0\n"
