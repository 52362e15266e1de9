"""Rules for robots that are not busy: ``stay``, ``rest-nearest``, ``rest-middle`` and ``charge-when-low``."""

from rmfs_rules.idle.rules import ChargeWhenLow, RestMiddle, RestNearest, Stay

__all__ = ["ChargeWhenLow", "RestMiddle", "RestNearest", "Stay"]
