from .decider import Decider, decide
from .deciding import Answer, Outcome
from .recorded import Recorded, Recording, read_recording
from .state import State, state_schema
from .state_json import read_state, state_from_dict, state_to_dict

__all__ = [
    "Answer",
    "Decider",
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
