// Words around the pictures: the legend, the figures of a view, the names that can be searched for.

import { clockTime } from "./clock.mjs";
import { featuresOf } from "./features.mjs";
import { HEATS } from "./heat.mjs";
import { make } from "./panel.mjs";
import { doing, percent, phaseOf, plural } from "./story.mjs";

const NAMED = { pod: ({ pods }) => pods.name, station: ({ stations }) => stations.name, order: ({ orders }) => orders.name, bundle: ({ events }) => events.bundle_arrived?.name ?? [] };

/** Figures of a view now, in a line. */
export function numbers({ run, world, distance }) {
  const has = featuresOf(run);
  const waiting = has.bundles ? [`${plural(world.waitingBundles.size, "bundle")} waiting`] : [];
  const counted = [plural(world.done, "order"), plural(world.picks, "pick"), plural(world.visits, "visit")];
  const ended = world.tick > run.tick ? [`ended at ${clockTime(run.tick)}`] : [];
  return [...counted, `backlog ${world.backlog}`, ...waiting, `${(distance(world.tick) / 1000).toFixed(1)} km`, ...ended].join(", ");
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

/** What the signs mean that only some runs have. */
function more(runs, palette) {
  const has = (name) => runs.some((run) => featuresOf(run)[name]);
  const closed = swatch(palette.rest, "struck");
  closed.style.setProperty("--struck", palette.wait);
  const entries = [
    ["storing", swatch(palette.rest), "replenishment station"],
    ["bundles", swatch(palette.bundle, "small hollow"), "bundle without a pod"],
    ["bundles", swatch(palette.bundle, "small"), "with one"],
    ["chargers", swatch(palette.charge, "bolt"), "charger"],
    ["chargers", swatch(palette.charge, "ring"), "robot there, by its charge"],
    ["closed", closed, "closed"],
    ["moves", swatch(palette.moved, "dashed"), "pod moved without a visit"],
  ];
  return entries.filter(([name]) => has(name)).map(([, mark, text]) => entry(mark, text));
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
      ...more(views.map(({ run }) => run), palette),
    ),
  ];
}

/** A thing in a few words: its name, and what it is at. */
export function brief({ run, history, names, world }, { kind, id }) {
  const name = names[kind](id);
  if (kind === "robot") {
    const charge = world.charge(id);
    const said = doing(names, phaseOf(run, history, id, world.tick, world), false);
    return `${name}: ${said}${charge === null ? "" : `, ${percent(charge)} charged`}`;
  }
  if (kind !== "station") return name;
  const { bundles } = world.stations[id];
  const has = bundles.size ? [`${plural(bundles.size, "bundle")} to store`] : [];
  return [name, ...has, ...(world.closed.has(id) ? ["closed"] : [])].join(", ");
}

/** Names that the search knows, of each kind. */
export function suggestions({ run, names }) {
  const counts = { robot: run.legs.length, ...Object.fromEntries(["station", "pod", "order", "bundle"].map((kind) => [kind, NAMED[kind](run).length])) };
  return Object.entries(counts).flatMap(([kind, n]) => Array.from({ length: Math.min(n, 300) }, (_, id) => names[kind](id)));
}

/** The thing that a text names: `robot 3`, `pod 12`, `station 1`, `order 7`, `bundle 2`; null for none. */
export function thingNamed({ run }, text) {
  const [, kind, name] = /^\s*(robot|pod|station|order|bundle)s?\s+(.+?)\s*$/i.exec(text) ?? [];
  if (!kind) return null;
  const lower = kind.toLowerCase();
  const id = lower === "robot" ? Number(name) - 1 : NAMED[lower](run).indexOf(name);
  const there = lower === "robot" ? Number.isInteger(id) && id >= 0 && id < run.legs.length : id >= 0;
  return there ? { kind: lower, id } : null;
}
