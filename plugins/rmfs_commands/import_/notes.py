"""Notes on parts of a file without a counterpart in rmfs: their number, and the replacement."""

from __future__ import annotations

from attrs import define, field, frozen


@frozen
class Note:
    """Something without a counterpart.

    Parameters
    ----------
    what
        Its name in the plural, as the file's format has it.
    number
        How many there are.
    instead
        Their treatment.
    """

    what: str
    number: int
    instead: str


@define
class Notes:
    """The notes of an import, in the order in which they were taken."""

    taken: list[Note] = field(factory=list)

    def add(self, what: str, number: int, instead: str = "left out") -> None:
        """Take a note, unless there is nothing to say."""
        if number:
            self.taken.append(Note(what, number, instead))


@define
class Imported:
    """Files made by an import.

    Parameters
    ----------
    kind
        The format of what was read, for people.
    read
        How many of what was read.
    files
        Texts to write, by the names of their files.
    command
        Command that takes these files, as words after ``rmfs``; ``{}`` stands for the folder.
    notes
        Things without a counterpart.
    """

    kind: str
    read: dict[str, int]
    files: dict[str, str]
    command: str
    notes: Notes
