// Words around the pictures: the legend, the figures of a view, the names that can be searched for.

import { clockTime } from "./clock.mjs";
import { HEATS } from "./heat.mjs";
import { make } from "./panel.mjs";
import { plural } from "./story.mjs";

const KINDS = { robot: "robots", pod: "pods", station: "stations", order: "orders" };

/** Figures of a view now, in a line. */
export function numbers({ run, world, distance }) {
  const counted = [plural(world.done, "order"), plural(world.picks, "pick"), plural(world.visits, "visit")];
  const ended = world.tick > run.tick ? [`ended at ${clockTime(run.tick)}`] : [];
  return [...counted, `backlog ${world.backlog}`, `${(distance(world.tick) / 1000).toFixed(1)} km`, ...ended].join(", ");
}

const swatch = (colour, shape = "square") => make("i", { class: shape, style: `--colour: ${colour}` });
const entry = (mark, text) => make("span", {}, mark, text);

function classes(edges, colours) {
  return edges.map((edge, i) => {
    const low = (edges[i - 1] ?? -1) + 1;
    return entry(swatch(colours[Math.min(i, colours.length - 1)]), low === edge ? String(edge) : `${low}–${edge}`);
  });
}

function heatClasses(heat, colours) {
  const unit = heat.unit && ` ${heat.unit}`;
  const first = colours.length - heat.edges.length;
  return heat.edges.map((edge, i) => entry(swatch(colours[first + i]), `up to ${edge}${unit}`));
}

/** What the colours mean. */
export function legend(views, name, palette) {
  const { heat } = views[0].scene;
  const scale = heat
    ? [make("b", {}, heat.label), ...heatClasses(heat, palette.heats), make("span", { class: "soft" }, HEATS[name].says)]
    : [make("b", {}, "Open items on a pod"), ...classes(views[0].edges, palette.levels)];
  return [
    make("div", {}, ...scale),
    make("div", {},
      entry(swatch(palette.robot, "round"), "robot"),
      entry(swatch(palette.wait, "round"), "waits on its way"),
      entry(swatch(palette.idle, "round"), "idle"),
      entry(swatch(palette.work, "round"), "picker at work"),
      entry(swatch(palette.rest, "round"), "not at work"),
      entry(swatch(palette.accent, "small"), "open order"),
      entry(swatch(palette.empty, "hollow"), "empty pod"),
    ),
  ];
}

/** Names that the search knows, of each kind. */
export function suggestions({ run, names }) {
  const counts = { robot: run.legs.length, station: run.stations.name.length, pod: run.pods.name.length, order: run.orders.name.length };
  return Object.entries(counts).flatMap(([kind, n]) => Array.from({ length: Math.min(n, 300) }, (_, id) => names[kind](id)));
}

/** The thing that a text names: `robot 3`, `pod 12`, `station 1`, `order 7`; null for none. */
export function thingNamed({ run }, text) {
  const [, kind, name] = /^\s*(robot|pod|station|order)s?\s+(.+?)\s*$/i.exec(text) ?? [];
  if (!kind) return null;
  const lower = kind.toLowerCase();
  const id = lower === "robot" ? Number(name) - 1 : run[KINDS[lower]].name.indexOf(name);
  const there = lower === "robot" ? Number.isInteger(id) && id >= 0 && id < run.legs.length : id >= 0;
  return there ? { kind: lower, id } : null;
}
