"""Placements: which SKUs stand on which pods, how many items of each, and where the pods stand.

The pods, the number of SKUs on each, its space, and the items of each SKU stay as they are. Besides the placements of
`rmfs_commands.convert.placement`:

``clusters``
    As many pods as with ``popularity``. SKUs are clustered by how often they are ordered together (cosine of their
    orders, average linkage), and the pods are filled along the leaves of the tree.
``improved``
    The one that needs the fewest visits in the held-back part of the history, improved by local search.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray

from rmfs_commands.convert.lines import Sku
from rmfs_commands.convert.placement import PLACEMENTS, affinity_of, anywhere, copies_of, place
from rmfs_commands.slotting.past import Past
from rmfs_commands.slotting.surrogate import Batches, Ints, Shelves
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.randomness import stream
from rmfs_core.scenario.model import Scenario
from rmfs_core.simulation.setup import motion_of
from rmfs_core.world import Layout, PodData
from rmfs_core.world.travel import travel_on

NOW, CLUSTERS, IMPROVED, MOVES = "now", "clusters", "improved", "moves"
MADE = (*PLACEMENTS, CLUSTERS)
MOST_CLUSTERED = 3_000
"""SKUs that are clustered, those ordered most: the distances of all pairs have to fit into memory."""
MOST_LINES = 100_000
"""Order lines that the surrogate has, of orders spread evenly over the history."""
HELD_BACK = 0.2
"""Share of the history, its last orders, on which placements are chosen."""
ROUNDS = 10
"""Parts of the local search; after each, the held-back orders say whether it still helps."""
DRAWS = 6
_NO_LIMIT = 2**60
_MOST_REPAIRS = 10_000

Contents = list[list[tuple[int, int | None]]]
"""SKU id and items of each SKU on each pod; None: unlimited."""


@frozen(eq=False)
class Stock:
    """The stock of the pods, the same in each placement.

    Parameters
    ----------
    rooms
        Number of SKUs of each pod.
    items
        Items of each SKU; None: unlimited.
    sizes
        Space of an item, by SKU id.
    space
        Of each pod.
    """

    rooms: tuple[int, ...]
    items: tuple[int | None, ...]
    sizes: tuple[int, ...]
    space: int

    @classmethod
    def of(cls, past: Past, scenario: Scenario) -> Stock:
        """Return the stock of a scenario's pods."""
        instance = past.instance
        items: list[int | None] = [0] * len(instance.skus)
        for pod in instance.pods:
            for sku, number in pod.contents:
                held = items[sku]
                items[sku] = None if held is None or number is None else held + number
        sizes = instance.sizes or (1,) * len(instance.skus)
        space = scenario.instance.pod_capacity or _NO_LIMIT
        return cls(tuple(len(pod.contents) for pod in instance.pods), tuple(items), sizes, space)

    def load(self, sku: int, items: int | None) -> int:
        """Return the space of some items; an unlimited number takes none."""
        return self.sizes[sku] * (items or 0)

    def filled(self, held: Sequence[Sequence[int]]) -> Contents:
        """Return pods with the items of each SKU in equal parts; what is left over goes to the first pods."""
        copies, given = [0] * len(self.items), [0] * len(self.items)
        for sku in (sku for pod in held for sku in pod):
            copies[sku] += 1
        found: Contents = [[] for _ in held]
        for pod, skus in enumerate(held):
            for sku in skus:
                total = self.items[sku]
                share = None if total is None else total // copies[sku] + (given[sku] < total % copies[sku])
                given[sku] += 1
                found[pod].append((sku, share))
        return found

    def shelves(self, contents: Contents) -> Shelves:
        """Return pods as arrays."""
        held = [[sku for sku, _ in pod] for pod in contents]
        loads = [[self.load(*one) for one in pod] for pod in contents]
        return Shelves.of(held, loads, self.space, len(self.items))

    def fitted(self, contents: Contents) -> Contents | None:
        """Return pods of which none has more than its space, by exchanges; None where these lead nowhere."""
        contents = [list(pod) for pod in contents]
        for _ in range(_MOST_REPAIRS):
            loads = np.array([sum(self.load(*one) for one in pod) for pod in contents])
            full = int(loads.argmax())
            over = int(loads[full]) - self.space
            if over <= 0:
                return contents
            best: tuple[int, int, int, int] | None = None
            here = {sku for sku, _ in contents[full]}
            for other in np.argsort(loads, kind="stable")[:50].tolist():
                there = {sku for sku, _ in contents[other]}
                for i, one in enumerate(contents[full]):
                    for j, two in enumerate(contents[other]):
                        less = self.load(*one) - self.load(*two)
                        if less <= 0 or one[0] in there or two[0] in here:
                            continue
                        left = max(over - less, int(loads[other]) + less - self.space, 0)
                        if left < over and (best is None or left < best[0]):
                            best = left, i, other, j
            if best is None:
                return None
            _, i, other, j = best
            contents[full][i], contents[other][j] = contents[other][j], contents[full][i]
        return None


@frozen(eq=False)
class Placement:
    """A placement, and its visits per order in the part of the history that it was made by, and in that held back."""

    name: str
    contents: Contents
    seen: float
    held_back: float


class Placer:
    """Makes placements from a history.

    Parameters
    ----------
    past
        The history.
    stock
        Items on the pods.
    batch
        Orders of a batch of the surrogate.
    seed
        Of placements and search.
    """

    def __init__(self, past: Past, stock: Stock, batch: int, seed: int) -> None:
        self.past, self.stock, self._seed = past, stock, seed
        n, skus = len(past.baskets), len(stock.items)
        cut = n - round(HELD_BACK * n) if n >= 2 * batch else n
        self.learned = past.baskets[:cut]
        lines = sum(map(len, past.baskets)) / n * batch
        most = max(1, int(MOST_LINES / lines))
        self.seen = Batches.of(self.learned, batch, skus, most)
        self.held_back = Batches.of(past.baskets[cut:] or past.baskets, batch, skus, most)

    def judged(self, name: str, contents: Contents) -> Placement:
        """Return a placement with its visits."""
        shelves = self.stock.shelves(contents)
        return Placement(name, contents, shelves.visits(self.seen)[0], shelves.visits(self.held_back)[0])

    def visits(self, placement: Placement) -> Ints:
        """Return how often each pod is visited by the orders seen."""
        return self.stock.shelves(placement.contents).visits(self.seen)[1]

    def now(self) -> Placement:
        """Return the pods as they are."""
        return self.judged(NOW, [list(pod.contents) for pod in self.past.instance.pods])

    def made(self, name: str) -> Placement | None:
        """Return a placement of all orders seen; None where it does not fit into the space of the pods."""
        rng, skus = stream(self._seed, f"slotting {name}"), _counted(self.past.skus(), self.learned)
        limits = [self.stock.items[int(sku.name)] for sku in skus]
        pods = sum(room > 0 for room in self.stock.rooms)
        most = np.array([pods if limit is None else max(1, min(pods, limit)) for limit in limits], dtype=np.int64)
        baskets = [[str(sku) for sku in basket] for basket in self.learned]
        rooms = self.stock.rooms
        if name == CLUSTERS:
            held = _clustered(skus, rooms, baskets, most, rng)
        else:
            held = place(skus, rooms, name, rng, baskets, most)
        named = [[int(skus[sku].name) for sku in pod] for pod in held]
        contents = self.stock.fitted(self.stock.filled(named))
        return None if contents is None else self.judged(name, contents)

    def improved(self, start: Placement, steps: int) -> Placement:
        """Return a placement after a local search, as it was when the held-back orders needed the fewest visits."""
        shelves, rng = self.stock.shelves(start.contents), stream(self._seed, "slotting search")
        best, contents = start.held_back, start.contents
        for _ in range(ROUNDS):
            shelves.search(self.seen, rng.random((-(-steps // ROUNDS), DRAWS)))
            visits, _ = shelves.visits(self.held_back)
            if visits < best:
                best, contents = visits, self.with_items(start.contents, shelves)
        return self.judged(IMPROVED, contents)

    def with_items(self, start: Contents, shelves: Shelves) -> Contents:
        """Return the pods of shelves on which SKUs were exchanged with their items; a load tells the items of a SKU."""
        items = {(sku, self.stock.load(sku, number)): number for pod in start for sku, number in pod}
        return [
            [(int(sku), items[int(sku), int(load)]) for sku, load in zip(skus[:room], loads[:room], strict=True)]
            for skus, loads, room in zip(shelves.held, shelves.loads, shelves.rooms, strict=True)
        ]


def _counted(skus: Sequence[Sku], baskets: Sequence[Sequence[int]]) -> list[Sku]:
    """Return SKUs with the order lines of some baskets alone, most lines first."""
    lines = dict.fromkeys((int(sku.name) for sku in skus), 0)
    for sku in (sku for basket in baskets for sku in basket):
        lines[sku] += 1
    counted = [evolve(sku, lines=lines[int(sku.name)]) for sku in skus]
    return sorted(counted, key=lambda sku: (-sku.lines, int(sku.name)))


def _clustered(
    skus: Sequence[Sku], rooms: Sequence[int], baskets: Sequence[Sequence[str]], most: Ints, rng: np.random.Generator
) -> list[list[int]]:
    """Fill pods along the leaves of a tree of clusters: each SKU once, then those with a second pod, and so on."""
    from scipy.cluster.hierarchy import leaves_list, linkage
    from scipy.spatial.distance import squareform

    copies = copies_of(skus, sum(rooms), "popularity", rng, most)
    known = [i for i, sku in enumerate(skus) if sku.lines > 0][:MOST_CLUSTERED]
    order = known
    if len(known) > 2:
        together = affinity_of(skus, baskets)[known][:, known].toarray().astype(float)
        lines = np.sqrt(together.diagonal())
        distance = 1 - together / np.outer(lines, lines)
        np.fill_diagonal(distance, 0)
        order = [known[leaf] for leaf in leaves_list(linkage(squareform(distance, checks=False), "average")).tolist()]
    held: list[list[int]] = [[] for _ in rooms]
    waiting = list(_levels(order, copies))[::-1]
    for pod, room in zip(held, rooms, strict=True):
        while waiting and len(pod) < room:
            if (sku := waiting.pop()) not in pod:
                pod.append(sku)
    placed = np.bincount([sku for pod in held for sku in pod], minlength=len(skus))
    return anywhere(np.where(placed > 0, 0, copies), rooms, held, rng)


def _levels(order: Sequence[int], copies: Ints) -> Iterator[int]:
    """Yield the SKUs in order, then those that stand on more than one pod, then on more than two; known ones only."""
    for level in range(int(copies[list(order)].max(initial=0))):
        yield from (sku for sku in order if copies[sku] > level)


def driving_s(scenario: Scenario, layout: Layout) -> NDArray[np.float64]:
    """Return the mean seconds from each storage location to the picking stations, with a pod and without traffic."""
    travel = travel_on(layout, motion_of(scenario.robots))
    cells = np.array(layout.storage_locations)
    stations = layout.stations[: len(layout.stations) - layout.replenishing]
    times = [travel.times_to(one.station, loaded=True)[cells].min(axis=1) for one in stations]
    return np.asarray(np.mean(times, axis=0) / TICKS_PER_S)


def located(pods: Sequence[PodData], visits: Ints, layout: Layout, seconds: NDArray[np.float64]) -> list[int]:
    """Return the cell of each pod: the pods with most visits stand nearest to the stations.

    Of the storage locations where pods stand now, if that is known of all of them; else of all that there are.
    """
    allowed = cells_of(pods, layout) or list(layout.storage_locations)
    near = dict(zip(layout.storage_locations, seconds.tolist(), strict=True))
    allowed.sort(key=lambda cell: (near[cell], cell))
    found = [0] * len(pods)
    for pod, cell in zip(np.argsort(-visits, kind="stable").tolist(), allowed, strict=False):
        found[pod] = cell
    return found


def cells_of(pods: Sequence[PodData], layout: Layout) -> list[int]:
    """Return the cell where each pod stands at time 0; none where that is not known of all."""
    places = [pod.place for pod in pods if pod.place is not None]
    return [(row - 1) * layout.width + column - 1 for row, column, _ in places] if len(places) == len(pods) else []
