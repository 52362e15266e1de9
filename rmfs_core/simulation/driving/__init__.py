"""How robots drive in a run: the contract, and robots that are each alone."""
