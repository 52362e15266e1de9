"""Random streams."""

from rmfs_core.randomness import stream


def test_streams_depend_on_seed_and_purpose_only() -> None:
    """The same seed and purpose give the same draws; another purpose or seed gives others."""
    draws = stream(1, "orders").random(5).tolist()
    assert draws == stream(1, "orders").random(5).tolist()
    assert draws != stream(1, "pods").random(5).tolist()
    assert draws != stream(2, "orders").random(5).tolist()
