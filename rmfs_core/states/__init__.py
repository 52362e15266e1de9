"""Decision states: what a rule saw when it was asked, as JSON; recorded by runs, written by others, decided again."""

from rmfs_core.states.deciding import Answer, Outcome, decide
from rmfs_core.states.model import State, state_schema
from rmfs_core.states.reading import read_state, state_from_dict, state_to_dict
from rmfs_core.states.recorded import Recorded, Recording, read_recording

__all__ = [
    "Answer",
    "Outcome",
    "Recorded",
    "Recording",
    "State",
    "decide",
    "read_recording",
    "read_state",
    "state_from_dict",
    "state_schema",
    "state_to_dict",
]
