"""Citations: the sources that rules name, as BibTeX."""
