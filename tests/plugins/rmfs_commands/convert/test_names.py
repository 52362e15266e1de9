"""Names of orders and SKUs, spelled in one way."""

from __future__ import annotations

from rmfs_commands.convert.names import Names


def test_one_name_has_one_spelling() -> None:
    """Accents apart from their letters, spaces around, line ends within; those respelled are counted."""
    names = Names()
    assert [names.clean(text) for text in (" A 1 ", "cafe\u0301", "caf\u00e9", "two\r\nlines", "A  1", "\u00a0x")] == [
        "A 1",
        "caf\u00e9",
        "caf\u00e9",
        "two lines",
        "A  1",
        "x",
    ]
    assert names.respelled == 1
