"""Decision states: what a rule saw when it was asked, as JSON; recorded by runs, written by others, decided again."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
