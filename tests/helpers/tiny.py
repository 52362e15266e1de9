TINY = """
[instance]
orders = 6
skus = 8
pods = 6
skus_per_pod = 3
[layout]
block_rows = 3
block_columns = 2
stations_east = 1
[robots]
count = 2
[rules]
poa = "pod-match"
pps = "demand"
pp = "free-flow"
"""

TWO_RULES = """
base = "tiny.toml"
seeds = [1, 2]
baseline = "pod-match"
[[rule_sets]]
name = "pod-match"
[[rule_sets]]
name = "first-come"
rules.poa = "first-come"
"""
"""An experiment on it."""
