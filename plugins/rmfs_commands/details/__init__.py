"""The metrics of a run; what happens hour by hour, at each station, to each robot and order, and metrics of that."""
