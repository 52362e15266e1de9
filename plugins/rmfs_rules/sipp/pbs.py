"""Priority-based search over the paths of all robots on their way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from attrs import define, field

from rmfs_core import Path, hookimpl
from rmfs_rules.helpers.parameters import NOT_NEGATIVE, parameter
from rmfs_rules.sipp.priorities import Search
from rmfs_rules.sipp.rule import Sipp

if TYPE_CHECKING:
    from rmfs_traffic import FleetTraffic, Query, Roads


@define
class Pbs:
    """Let those on their way yield to robots that set out, or the other way round, whichever costs less time.

    Robots that need a path plan one after another with the search of `sipp`, among the reservations of all others. If
    they would be at their goals sooner without those on their way, a priority-based search begins: a node has a path
    for each robot and an order of some pairs of them; at first robots that set out have the paths that are best for
    them, and the others theirs. Of the first two robots whose paths cross, either one goes first, in a child each: the
    other and all that come after it plan again, where they cross somebody that goes before them. Depth first, the
    child with the lower sum of arrivals next; what is no better than the best so far is left out.

    The paths whose arrivals add up to least are the answer. Each leads to its goal: a window, as in RHCR, beyond which
    paths may cross, would leave robots without the paths on which it rests that no run stands still.

    References
    ----------
    H. Ma, D. Harabor, P. J. Stuckey, J. Li, S. Koenig: Searching with consistent prioritization for multi-agent path
    finding. AAAI 2019. https://doi.org/10.1609/aaai.v33i01.33017643

    J. Li, A. Tinka, S. Kiesel, J. W. Durham, T. K. S. Kumar, S. Koenig: Lifelong multi-agent path finding in
    large-scale warehouses. AAAI 2021. https://doi.org/10.1609/aaai.v35i13.17344
    """

    reserves: ClassVar[str] = "fleet"

    most_nodes: int = parameter(20, NOT_NEGATIVE, "Nodes after which a search ends")

    _sipp: Sipp = field(init=False, factory=Sipp, repr=False, eq=False)

    def prepare(self, roads: Roads) -> None:
        """Load the compiled search, or compile it."""
        self._sipp.prepare(roads)

    @hookimpl
    def plan_paths(self, queries: Sequence[Query], traffic: FleetTraffic) -> dict[int, Path]:
        """Return the paths whose arrivals add up to least, of those found."""
        return Search(self._sipp, queries, traffic).best(self.most_nodes)
