"""How a period is proven optimal: a bound from below, a solution from above, until they meet.

Open `steps` first: it has what is tried, in its order, on what is known so far (`proof`). From below come `flow`,
`fewest` and `patterns` (with `pricing`); from above `feasible` and whatever those find. What is left over goes to a
solver in the aggregated form (`aggregated`, written down as a `program`). `ties` chooses among optima.
"""
