from .choices import FEATURES, Choice, Feature
from .making import make
from .policy import PolicyRule
from .rewards import REWARDS, Step

__all__ = ["FEATURES", "REWARDS", "Choice", "Feature", "PolicyRule", "Step", "make"]
