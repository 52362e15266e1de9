"""What to cite: the sources that rules name, as BibTeX."""
