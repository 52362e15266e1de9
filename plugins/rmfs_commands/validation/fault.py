"""Kinds of faults in a trace."""

from __future__ import annotations

from attrs import frozen

from rmfs_core.clock import to_seconds


@frozen
class Fault:
    """Something in a trace that cannot have happened.

    Parameters
    ----------
    kind
        One of `KINDS`.
    tick
        When, in ticks since the start of the run.
    sentence
        What, with the names of robots, pods, cells, stations and orders.
    """

    kind: str
    tick: int
    sentence: str

    @property
    def time_s(self) -> float:
        """When, in seconds since the start of the run."""
        return to_seconds(self.tick)


KINDS: dict[str, str] = {
    # The trace as such
    "header": "the header contradicts itself, or its scenario makes another start",
    "unknown-id": "an event names something that does not exist",
    "time-order": "an event lies before the one above it, or behind the end of the run",
    "end": "the run ends at another time than it should",
    # Robots
    "teleport": "a run starts where the robot is not",
    "time-overlap": "a robot does two things at once",
    "negative-time": "a robot waits or turns for less than no time",
    "not-straight": "a run follows neither a row nor a column",
    "distance": "the distance of a run is not that between its ends",
    "heading": "a robot drives in another direction than it faces",
    "turn-time": "a turn takes another time than the formula",
    "too-fast": "a run beats the limits of speed and acceleration",
    "too-slow": "a run takes longer than the formula",
    "wall": "a robot drives through a wall",
    "one-way": "a robot leaves a cell in a direction in which it may not be left",
    "queue-lane": "a robot uses the queue of a station that it does not go to",
    "collision": "two robots hold a cell at once",
    "swap": "two robots drive through each other",
    # Pods
    "pod-mismatch": "a robot drives with another load than it lifted",
    "through-stored-pod": "a robot with a pod drives into a stored pod",
    "storage-crossed": "a robot with a pod crosses a storage location or a charger",
    "pod-not-there": "a pod is lifted where it does not stand",
    "pod-in-use": "a pod is lifted or set down that another robot carries, or none",
    "robot-loaded": "a robot with a pod lifts another one",
    "robot-elsewhere": "a robot lifts, sets down, queues or serves where it does not stand",
    "lift-time": "lifting or setting down takes another time than it should",
    "location-taken": "two pods stand in one storage location",
    "no-storage-location": "a pod stands somewhere else than in a storage location",
    "not-stored": "a robot stands with its pod where that is to be stored, and does not set it down",
    "no-task": "a robot lifts a pod that it was not told to fetch",
    "no-trip": "a robot gets a task to fetch a pod that is bound for no station",
    "fetched-twice": "a robot gets a task to fetch a pod that another one fetches or carries",
    "robot-busy": "a robot gets a task, or is sent to rest, while it is busy",
    "off-duty": "a robot gets a task while it is off duty",
    "outage": "something is out of service, or back, at another time or cell than the seed and the timetable say",
    "out-of-service": "a robot gets a task, or an item is picked at a station, while that is out of service",
    "robot-hours": "robots come on or off duty at another time than the timetable says",
    "moved-bound": "a pod is carried elsewhere that is bound for a station",
    "moved-elsewhere": "a pod that is carried elsewhere is set down somewhere else",
    # Robots without a task
    "no-rest": "a robot is sent to rest where it must not",
    "rested": "a robot rests that was not sent, or somewhere else than it stands",
    # Lines and visits
    "queue-too-long": "a station has more pods in line than its queue holds",
    "joined-late": "a robot has waited in a queue and joined its line only when it was served",
    "queue-order": "a pod is served before one that came earlier",
    "queue-passed": "a robot stands nearer to a station than its position in line is",
    "station-busy": "two pods are at one station",
    "not-bound": "a pod visits a station that it is not bound for, or not yet",
    "bound-twice": "a pod is sent to a station for which it is bound already",
    "visit-number": "visits are not counted up one by one",
    "visit-end": "a visit ends that is not under way",
    "visit-picks": "a visit reports another number of picks than it had",
    "moved-in-visit": "a robot leaves its station during the visit",
    "next-station": "a pod goes on to somewhere else than its visit's end says",
    "left-early": "a pod leaves a station that it can still serve",
    # Picks
    "no-visit": "an item is picked from a pod that is not at the station",
    "pick-time": "a pick takes another time than it should",
    "handle-time": "handling an item takes another time than it should",
    "picker-busy": "a picker starts an item before the last one is handled",
    "not-ordered": "an item is picked that the order does not have",
    "not-assigned": "an item is picked at a station where it is not assigned",
    "picked-twice": "more items are picked than were ordered",
    "sku-not-on-pod": "an item is picked from a pod without the SKU",
    "stock-negative": "more items are picked from a pod than it held",
    # Bundles
    "bundle-arrival": "a bundle arrives that was not to come then, or does not",
    "bundle-twice": "a bundle is assigned, given a pod, or stored again",
    "bundle-capacity": "a station has more bundles than it holds",
    "bundle-elsewhere": "a bundle is stored on another pod or at another station than was decided",
    "bundle-items": "a bundle is stored with other items than it came with",
    "pod-capacity": "a pod holds, or is to hold, more than fits on it",
    "store-time": "storing a bundle takes another time than it should",
    # Orders
    "arrival": "an order arrives at another time than it should, or twice",
    "assigned-before-arrival": "an order is assigned before it arrived",
    "assigned-without-stock": "an order is assigned while the pods hold too little for it",
    "in-stock": "an order that waited for stock joins the backlog at another time than it should",
    "cancelled": "an order is cancelled when it should not be, or is not when it should be, or is assigned afterwards",
    "line-assigned": "a line is assigned that the order does not have or that was assigned before",
    "items": "a part has another number of items than its lines",
    "complete-flag": "an order is said to be fully assigned and is not, or the other way round",
    "station-closed": "a station is assigned an order while it is closed",
    "station-hours": "a station opens or closes at another time than its timetable says",
    "capacity-exceeded": "a station has more assigned than its capacity",
    "completed-early": "an order is complete with items left",
    "completed-late": "an order is complete at another time than its last pick, or when that is handled",
    "completed-twice": "an order is completed again",
    "order-left": "the run is complete and an order is not",
    "status": "all orders are complete and the run is not",
    "period": "periods are not counted up one by one",
    "rule": "a decision was made by another rule than the scenario names, or not as that rule does",
    "bound": "a decision has a bound above its objective",
    "report": "a decision has a status, an objective or a bound that its rule cannot report",
    "backlog": "a decision reports another backlog than there was",
    "decision-size": "a decision reports another number of assignments or trips than it had",
    # Packing
    "packing-bound": "an order is bound for a packing station twice, too early, or with a box though it is not split",
    "box": "two orders have one box, or more have one than there are",
    "tote": "a tote leaves with other items than it should, or at another time",
    "conveyor-time": "a tote is on its conveyor for another time than it should",
    "put": "a part is put into a box before it has come, again, or in another time than it should",
    "consolidated": "an order is said to be complete in its box and is not",
    "packed-early": "an order is begun to be packed before its last part is there",
    "pack-time": "packing takes another time than it should, or is done twice",
    "packers": "more packers or sorters are at work than there are, or they begin while they are closed",
    "not-packed": "the run is complete and an order is not packed",
    # The result
    "other-run": "the result next to the trace is that of another run",
    "metric": "a metric is not what the events amount to",
    "table": "a figure in a table next to the trace is not what the events amount to",
}
"""Every kind of fault by its name, and what it means."""

OF_FLOOR = frozenset(
    (
        *("not-straight", "heading", "turn-time", "too-fast", "too-slow", "wall", "one-way", "queue-lane"),
        *("through-stored-pod", "storage-crossed", "queue-passed", "joined-late", "bundle-arrival", "station-hours"),
        *("lift-time", "pick-time", "handle-time", "store-time", "conveyor-time", "tote", "put", "pack-time"),
        "time-overlap",
    )
)
"""Kinds that are no faults of a real day: ways and times are the floor's, and so is when bundles and stations come."""

OF_FIGURES = frozenset(("header", "unknown-id", "time-order", "end", "other-run", "metric", "table"))
"""Kinds that are faults of a real day also once the floor has corrected what was known."""
