import json
from pathlib import Path

import pytest

import releases
from cases import cases


@pytest.fixture(autouse=True)
def history(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "history.json"
    file.write_text(json.dumps({"1.0": {"load": 5.0, "other": 5.0}, "1.1": {"load": 10.0}}), encoding="utf-8")
    monkeypatch.setattr(releases, "HISTORY", file)


@cases(
    "measured least said",
    ([10.9], 10.9, None),
    ([12.0, 10.5], 10.5, None),  # what seems slower is measured again
    ([12.0, 11.5, 13.0], 11.5, "slower: load: 10.0 yardsticks in 1.1, 11.5 now (1.15 times)"),
)
def test_what_is_slower_than_in_the_last_release_is_named(measured, least, said) -> None:
    left = iter(measured)
    assert releases.held_against_release("load", lambda: next(left)) == (least, said)
    assert list(left) == []


def test_what_no_release_has_is_only_measured() -> None:
    assert releases.held_against_release("other", lambda: 99.0) == (99.0, None)
