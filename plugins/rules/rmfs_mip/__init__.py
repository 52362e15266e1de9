"""Pick order assignment and pod selection in one optimisation per period: three models and their exact solution.

Xie, Thieme, Krenzler, Li, "Efficient order picking methods in robotic mobile fulfillment systems", arXiv:1902.03092,
https://doi.org/10.48550/arXiv.1902.03092. Numbers in parentheses are that paper's equations.
"""

from rmfs_mip.rules import Integrated, SplitAmongStations, SplitOverTime

__all__ = ["Integrated", "SplitAmongStations", "SplitOverTime"]
