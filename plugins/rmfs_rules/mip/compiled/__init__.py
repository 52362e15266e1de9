"""The searches of `rmfs_rules.mip.proof` that are compiled by numba: exact, with a bound on the work.

They look at a period as `arrays`: `pod_sets` finds sets of pods that complete orders, `spreading` the stations that the
pods of a set are sent to, `stacking` the orders that fill these. `warm_up` loads them before a run.
"""
