from .choices import FEATURES, Choice, Feature
from .learned import Learned, RowNetwork, read_networks, write_networks
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
    "read_networks",
    "write_networks",
]
