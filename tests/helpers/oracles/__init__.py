"""Literal, slow versions of the shipped rules, from what is documented of them, and random worlds to compare them in.

They look at orders, pods and stations one after another in plain Python, and apply each choice to a world of their own
before the next one, so they share no bookkeeping with the rules.
"""
