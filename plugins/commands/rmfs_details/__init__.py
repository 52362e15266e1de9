"""What happens hour by hour, at each station, to each robot and to each order, and metrics made of it."""
