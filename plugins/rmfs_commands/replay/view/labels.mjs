// @ts-check
// Words around the pictures: the legend, the figures of a view, the names that can be searched for.

import { clockTime } from "./clock.mjs";
import { featuresOf } from "./features.mjs";
import { make } from "./panel.mjs";
import { doing, percent, phaseOf, plural } from "./story.mjs";
/** @import { Kind, Palette, Run, Thing, View } from "./types.d.ts" */

/** @type {Record<Exclude<Kind, "robot">, (run: Run) => string[]>} */
const NAMED = {
  station: ({ stations }) => stations.name,
  pod: ({ pods }) => pods.name,
  order: ({ orders }) => orders.name,
  bundle: ({ events }) => events.bundle_arrived.name,
};

/** @type {Kind[]} */
const KINDS = ["robot", "station", "pod", "order", "bundle"];

/**
 * Figures of a view now, in a line.
 * @param {View} view
 */
export function numbers({ run, world, distance }) {
  const has = featuresOf(run);
  const waiting = has.bundles ? [`${plural(world.waitingBundles.size, "bundle")} waiting`] : [];
  const counted = [plural(world.done, "order"), plural(world.picks, "pick"), plural(world.visits, "visit")];
  const packed = has.packing ? [`${world.packing.reduce((sum, one) => sum + one.packed, 0)} packed`] : [];
  const ended = world.tick > run.tick ? [`ended at ${clockTime(run.tick)}`] : [];
  return [...counted, ...packed, `backlog ${world.backlog}`, ...waiting, `${(distance(world.tick) / 1000).toFixed(1)} km`, ...ended].join(", ");
}

/** @param {string} colour */
function swatch(colour, shape = "square") {
  const mark = make("i", { class: shape });
  mark.style.setProperty("--colour", colour); // an attribute would be an inline style, which the page forbids itself
  return mark;
}

/**
 * @param {HTMLElement} mark
 * @param {string} text
 */
const entry = (mark, text) => make("span", {}, mark, text);

/**
 * @param {number[]} edges
 * @param {string[]} colours
 */
function classes(edges, colours) {
  return edges.map((edge, i) => {
    const low = (edges[i - 1] ?? -1) + 1;
    return entry(swatch(colours[Math.min(i, colours.length - 1)]), low === edge ? String(edge) : `${low}–${edge}`);
  });
}

/**
 * @param {{ edges: number[], unit: string }} heat
 * @param {string[]} colours
 */
function heatClasses(heat, colours) {
  const unit = heat.unit && ` ${heat.unit}`;
  const first = colours.length - heat.edges.length;
  return heat.edges.map((edge, i) => entry(swatch(colours[first + i]), `up to ${edge}${unit}`));
}

/**
 * What the signs mean that only some runs have.
 * @param {Run[]} runs
 * @param {Palette} palette
 */
function more(runs, palette) {
  /** @param {keyof ReturnType<typeof featuresOf>} name */
  const has = (name) => runs.some((run) => featuresOf(run)[name]);
  const closed = swatch(palette.rest, "struck");
  closed.style.setProperty("--struck", palette.wait);
  /** @type {[keyof ReturnType<typeof featuresOf>, HTMLElement, string][]} */
  const entries = [
    ["storing", swatch(palette.rest), "replenishment station"],
    ["bundles", swatch(palette.bundle, "small hollow"), "bundle without a pod"],
    ["bundles", swatch(palette.bundle, "small"), "with one"],
    ["chargers", swatch(palette.charge, "bolt"), "charger"],
    ["chargers", swatch(palette.charge, "ring"), "robot there, by its charge"],
    ["maintenance", swatch(palette.charge, "cross"), "maintenance cell"],
    ["down", swatch(palette.rest, "round"), "robot out of service"],
    ["closed", closed, "closed"],
    ["moves", swatch(palette.moved, "dashed"), "pod moved without a visit"],
    ["packing", swatch(palette.accent, "small hollow"), "box of an order, filled by its items"],
    ["packing", swatch(palette.work, "small"), "being put or packed"],
    ["packing", swatch(palette.bundle, "small"), "waiting"],
    ["packing", swatch(palette.bundle, "small hollow"), "on a conveyor"],
  ];
  return entries.filter(([name]) => has(name)).map(([, mark, text]) => entry(mark, text));
}

/**
 * What the colours mean.
 * @param {View[]} views
 * @param {Palette} palette
 */
export function legend(views, palette) {
  const { heat } = views[0].scene;
  const scale = heat
    ? [make("b", {}, heat.label), ...heatClasses(heat, palette.heats), make("span", { class: "soft" }, heat.says)]
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

/**
 * A thing in a few words: its name, and what it is at.
 * @param {View} view
 * @param {Thing} thing
 */
export function brief({ run, history, names, world }, { kind, id }) {
  const name = names[kind](id);
  if (kind === "robot") {
    const charge = world.charge(id);
    const said = doing(names, phaseOf(run, history, id, world.tick, world), false);
    return `${name}: ${said}${charge === null ? "" : `, ${percent(charge)} charged`}`;
  }
  if (kind === "packing") return `${name}: ${world.boxes(id).size === 1 ? "1 box" : `${world.boxes(id).size} boxes`} in use, ${world.packing[id].waiting - world.putting(id)} waiting`;
  if (kind !== "station") return name;
  const { bundles } = world.stations[id];
  const has = bundles.size ? [`${plural(bundles.size, "bundle")} to store`] : [];
  return [name, ...has, ...(world.closed.has(id) ? ["closed"] : [])].join(", ");
}

/**
 * How many things of a kind there are.
 * @param {Run} run
 * @param {Kind} kind
 */
const countOf = (run, kind) => (kind === "robot" ? run.legs : NAMED[kind](run)).length;

/**
 * Names that the search knows, of each kind.
 * @param {View} view
 */
export function suggestions({ run, names }) {
  const packing = Array.from({ length: run.packing?.stations ?? 0 }, (_, id) => names.packing(id));
  return [...KINDS.flatMap((kind) => Array.from({ length: Math.min(countOf(run, kind), 300) }, (_, id) => names[kind](id))), ...packing];
}

/**
 * The thing that a text names: `robot 3`, `pod 12`, `station 1`, `order 7`, `bundle 2`, `packing station 1`; null for none.
 * @param {View} view
 * @param {string} text
 * @returns {Thing | null}
 */
export function thingNamed({ run }, text) {
  const [, number] = /^\s*packing\s+station\s+(\d+)\s*$/i.exec(text) ?? [];
  if (number && Number(number) >= 1 && Number(number) <= (run.packing?.stations ?? 0)) return { kind: "packing", id: Number(number) - 1 };
  const [, word, name] = /^\s*(robot|pod|station|order|bundle)s?\s+(.+?)\s*$/i.exec(text) ?? [];
  const kind = KINDS.find((one) => one === word?.toLowerCase());
  if (!kind) return null;
  const id = kind === "robot" ? Number(name) - 1 : NAMED[kind](run).indexOf(name);
  return Number.isInteger(id) && id >= 0 && id < countOf(run, kind) ? { kind, id } : null;
}
