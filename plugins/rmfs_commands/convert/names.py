"""Names of orders and SKUs, spelled in one way."""

from __future__ import annotations

import unicodedata

from rmfs_core.wording import shown_short


def short(name: str) -> str:
    """Return a name as part of a sentence: on one line, without the end of a long one."""
    return shown_short(name)[1:-1]


class Names:
    """Cleans names.

    Attributes
    ----------
    respelled
        Names whose letters with accents were written as letter and accent apart (NFD).
    """

    def __init__(self) -> None:
        self.respelled = 0

    def clean(self, text: str) -> str:
        """Return a name on one line, without spaces around it, in the composed spelling of Unicode (NFC)."""
        name = text.strip()
        if name.isascii() and name.isprintable():
            return name
        if not unicodedata.is_normalized("NFC", name):
            self.respelled += 1
            name = unicodedata.normalize("NFC", name).strip()
        return " ".join(name.split()) if "\n" in name or "\r" in name else name
