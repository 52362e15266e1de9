"""`rmfs report`: one page on a run."""
