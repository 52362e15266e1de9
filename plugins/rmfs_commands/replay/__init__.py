"""`rmfs replay`: a recorded run as a page to watch, as pictures, or as a video; `replay` shows it in a notebook."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
