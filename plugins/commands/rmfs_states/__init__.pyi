from .deciding import Answer, Outcome, decide
from .model import State, state_schema
from .reading import read_state, state_from_dict, state_to_dict
from .recorded import Recorded, Recording, read_recording

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
