from .notebook import Page, replay

__all__ = ["Page", "replay"]
