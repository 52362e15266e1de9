"""The three models as the paper prints them.

`models` builds them variable by variable, `constraints` checks any solution by them, however it was found, and
`solver` is the way to python-mip's solvers, for them and for what `rmfs_rules.mip.proof` cannot settle itself.
"""
