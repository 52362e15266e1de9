"""Random streams."""

from rmfs_core.randomness import stream


def test_streams_depend_on_seed_and_purpose_only() -> None:
    """The same seed and purpose give the same draws; another purpose or seed gives others."""
    draws = stream(1, "orders").random(5).tolist()
    assert draws == stream(1, "orders").random(5).tolist()
    assert draws != stream(1, "pods").random(5).tolist()
    assert draws != stream(2, "orders").random(5).tolist()


def test_any_name_has_a_stream() -> None:
    """Also one with bytes that are no text, as names of files may have them: what is wrong is for others to say."""
    assert stream(1, "rule x\udcff").random() != stream(1, "rule x").random()
