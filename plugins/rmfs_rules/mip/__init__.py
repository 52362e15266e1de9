"""Pick order assignment and pod selection in one optimisation per period: three models and their exact solution.

How a period goes from the warehouse to a proven decision:

1. `rules`: a rule is asked and reads the period off the warehouse (`period.period`).
2. `period.reduction`: what no optimum depends on is dropped or counted.
3. `proof.steps`: steps in a fixed order raise a lower bound on the objective (1) or offer a solution, until both meet:
   maximum flow and its cuts (`proof.flow`) against quick solutions (`proof.feasible`); the fewest visits, one value
   after another (`proof.fewest`, with the searches in `compiled`); column generation (`proof.patterns`); as the last
   resort the solver, with the model in the aggregated form (`proof.aggregated`).
4. `proof.ties`: among the optima, another one may be preferred.
5. `printed.constraints`: whatever found it, the solution is checked by the constraints as the paper prints them.

With ``formulation = "paper"`` a solver gets the models as printed (`printed.models`) instead of 2 to 4. The folders
import one way: `proof` from `printed`, `compiled` and `period`; `printed` and `compiled` from `period`.

Xie, Thieme, Krenzler, Li, "Efficient order picking methods in robotic mobile fulfillment systems", arXiv:1902.03092,
https://doi.org/10.48550/arXiv.1902.03092. Numbers in parentheses are that paper's equations.
"""

from rmfs_rules.mip.rules import Integrated, SplitAmongStations, SplitOverTime

__all__ = ["Integrated", "SplitAmongStations", "SplitOverTime"]
