"""Order lines of a real warehouse, from whatever table they are in, as the files that a scenario reads."""
