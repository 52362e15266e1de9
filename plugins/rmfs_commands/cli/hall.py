"""The hall of a scenario before its run: a page, or a picture in a notebook."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from string import Template

import numpy as np
from attrs import field, frozen

from rmfs_commands.cli.loads import load_sentences, loads
from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.layouts.hall import HALL_STYLE, LEVELS, HallPod, hall_legend, hall_svg
from rmfs_core.scenario import Scenario, load_scenario, located
from rmfs_core.simulation.setup import open_warehouse
from rmfs_core.wording import counted
from rmfs_core.world import Instance, make_instance, make_layout

_PAGE = Template("""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<title>$title</title><style>
:root { color-scheme: light dark; --ink: #1c2126; --soft: #5b6470; --page: #f4f6f8; --card: #ffffff; --line: #d9dde3; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8ebee; --soft: #9aa5b1; --page: #0f1317; --card: #171c21; --line: #343c45; }
}
body { margin: 0; padding: 1rem; color: var(--ink); background: var(--page);
  font: 14px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
h1 { font-size: 1.2rem; margin: 0 0 .3rem; overflow-wrap: anywhere; } p { margin: .2rem 0; overflow-wrap: anywhere; }
.hall { background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: .8rem; margin: .8rem 0; }
.soft { color: var(--soft); }
$style</style></head><body><h1>$title</h1>$told<div class="hall">$figure</div>$said</body></html>
""")


@frozen(eq=False)
class Hall:
    """The picture of a hall before a run; a notebook shows it.

    Parameters
    ----------
    name
        Of the scenario.
    figure
        SVG and legend, for an element of the class ``hall``.
    sizes
        Sizes, in words.
    loads
        Sentences about the loads.
    """

    name: str
    figure: str = field(repr=False)
    sizes: str
    loads: Sequence[str] = field(repr=False)

    def _repr_html_(self) -> str:
        """Return the picture with its styles."""
        return f'<div class="hall"><style>{HALL_STYLE}</style>{self.figure}</div>'

    @property
    def html(self) -> str:
        """A page with everything in it, which needs no network."""
        return hall_page(f"{self.name}: the hall before a run", [self.sizes], self.figure, [*self.loads, NOT_SIMULATED])


def hall_page(title: str, told: Sequence[str], figure: str, said: Sequence[str]) -> str:
    """Return a page with a picture that `rmfs_commands.layouts.hall` draws; sentences are above and below it."""
    soft = ' class="soft"'
    below = "".join(f"<p{soft if one is NOT_SIMULATED else ''}>{escape(one)}</p>" for one in said)
    return _PAGE.substitute(
        title=escape(title),
        style=HALL_STYLE,
        told="".join(f'<p class="soft">{escape(sentence)}</p>' for sentence in told),
        figure=figure,
        said=below,
    )


def hall(scenario: Scenario | str, name: str | None = None) -> Hall:
    """Return a picture of the hall of a scenario at time 0, before a run.

    Stations with their queues, one-way aisles, chargers, robots, and pods, coloured by demand: the items that orders
    want of a SKU are shared evenly among the pods that have it.

    Parameters
    ----------
    scenario
        A scenario, a scenario file, or the name of a shipped scenario.
    name
        Name of the picture; None: as the scenario was given, or ``scenario``.

    Raises
    ------
    InputError
        When the scenario makes no sense.
    """
    loaded = load_scenario(scenario) if isinstance(scenario, str) else scenario
    name = name or (scenario if isinstance(scenario, str) else "scenario")
    with located(loaded):
        instance, layout = make_instance(loaded), make_layout(loaded)
        warehouse = open_warehouse(loaded, instance, layout).warehouse
        found = [*load_sentences(loads(loaded, instance, layout))]
    wanted = wanted_of_pods(instance)
    bounds = _bounds(wanted)
    levels = np.searchsorted(bounds, wanted, side="left") + (np.array(wanted) > 0)
    pods = [
        HallPod(at, int(levels[pod.id]), f"pod {pod.name}: {wanted[pod.id]:.1f} items wanted")
        for pod in warehouse.pods
        if (at := pod.location) is not None
    ]
    taken = {*warehouse.free_locations, *(pod.cell for pod in pods)}
    empty = [HallPod(cell, None, "empty pod") for cell in layout.storage_locations if cell not in taken]
    robots = [robot.cell for robot in warehouse.robots]
    figure = f'<div class="scroll">{hall_svg(layout, [*empty, *pods], robots)}</div>'
    figure += hall_legend(layout, _level_texts(bounds, levels), empty=bool(empty), robots=len(robots))
    sizes = [(instance.orders, "order"), (instance.skus, "SKU"), (instance.pods, "pod"), (robots, "robot")]
    told = ", ".join(counted(len(those), what) for those, what in sizes)
    if warehouse.packing and not layout.packing:
        told += f", {counted(len(warehouse.packing), 'packing station')} without a cell on the map"
    return Hall(name, figure, f"{told}; {layout.width} x {layout.height} cells of 1 m, seed {loaded.seed}", found)


def wanted_of_pods(instance: Instance) -> list[float]:
    """Return the items that orders want of each pod's SKUs, those of a SKU shared evenly among the pods with it."""
    wanted, pods_with = Counter[int](), Counter(sku for pod in instance.pods for sku, _ in pod.contents)
    for order in instance.orders:
        wanted.update(dict(order.lines))
    return [sum(wanted[sku] / pods_with[sku] for sku, _ in pod.contents) for pod in instance.pods]


def _bounds(wanted: Sequence[float]) -> list[float]:
    """Return up to where the shades but the last reach, so that each is that of as many pods, as far as they differ."""
    some = [items for items in wanted if items > 0]
    shares = np.arange(1, LEVELS - 1) / (LEVELS - 1)
    return np.unique(np.quantile(some, shares).round(1)).tolist() if some else []


def _level_texts(bounds: Sequence[float], levels: np.ndarray[tuple[int], np.dtype[np.int64]]) -> dict[int, str]:
    """Return what each shade that there is means."""
    ends = [f"up to {bound:g}" for bound in bounds] + [f"more than {bounds[-1]:g}" if bounds else "some"]
    texts = ["no", *ends]
    return {level: f"pods, {texts[level]} items wanted" for level in sorted(set(levels.tolist()))}
