from .choices import FEATURES, Choice, Feature
from .learned import Learned, RowNetwork, write_networks
from .making import make
from .policy import PolicyRule
from .rewards import REWARDS, Step

__all__ = [
    "FEATURES",
    "REWARDS",
    "Choice",
    "Feature",
    "Learned",
    "PolicyRule",
    "RowNetwork",
    "Step",
    "make",
    "write_networks",
]
