"""Files that a run reads and tables that it leaves, and the paper's generator of instances."""
