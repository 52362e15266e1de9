// Types of the page: what it is told of a run (`told` in replay/telling.py), and what its modules make of that.
// Nothing of this is in the page; `make js` checks the modules against it.

import type { Scene } from "./draw.mjs";
import type { Page } from "./page.mjs";
import type { Names } from "./story.mjs";
import type { Timeline } from "./timeline.mjs";
import type { World } from "./world.mjs";

declare global {
  interface Window {
    replay: Page;
  }
}

// What the page is told

/** Columns of equal length; `tick` has differences, `start_tick` and `picker_free_tick` distances to the event's own time. */
type Told<Column extends string> = Record<"tick" | Column, number[]>;

/** The events of each kind. -1 is none; a text is its index in `texts`. */
export type ToldEvents = {
  order_arrived: Told<"order">;
  order_in_stock: Told<"order">;
  order_assigned: Told<"order" | "station" | "skus" | "skus_n" | "items" | "period" | "complete">;
  trip_decided: Told<"pod" | "station">;
  task_assigned: Told<"robot" | "pod">;
  pod_lifted: Told<"start_tick" | "robot" | "pod" | "cell">;
  pod_stored: Told<"start_tick" | "robot" | "pod" | "cell">;
  queue_joined: Told<"robot" | "pod" | "station">;
  visit_started: Told<"visit" | "robot" | "pod" | "station">;
  item_picked: Told<"start_tick" | "picker_free_tick" | "visit" | "station" | "pod" | "order" | "sku">;
  visit_ended: Told<"visit" | "pod" | "station" | "picks" | "next_station">;
  order_cancelled: Told<"order">;
  order_completed: Told<"order">;
  packing_assigned: Told<"order" | "packing" | "box">;
  part_sent: Told<"order" | "packing" | "station" | "tote" | "items">;
  part_arrived: Told<"order" | "packing" | "tote" | "items">;
  part_put: Told<"start_tick" | "order" | "packing" | "tote" | "items">;
  order_consolidated: Told<"order" | "packing">;
  packing_started: Told<"order" | "packing">;
  order_packed: Told<"start_tick" | "order" | "packing">;
  bundle_arrived: Told<"bundle" | "name" | "sku" | "items">;
  bundle_assigned: Told<"bundle" | "station">;
  bundle_bound: Told<"bundle" | "pod">;
  bundle_stored: Told<"start_tick" | "visit" | "station" | "pod" | "bundle" | "sku" | "items">;
  station_opened: Told<"station">;
  station_closed: Told<"station">;
  robots_on_duty: Told<"number">;
  robot_down: Told<"robot" | "planned">;
  robot_up: Told<"robot">;
  station_down: Told<"station">;
  station_up: Told<"station">;
  charger_down: Told<"cell">;
  charger_up: Told<"cell">;
  robot_sent: Told<"robot" | "cell">;
  robot_rested: Told<"robot" | "cell">;
  pod_move_decided: Told<"robot" | "pod" | "cell">;
  decision_made: Told<"period" | "decides" | "rule" | "backlog" | "assignments" | "trips" | "status" | "stopped_early"> &
    Record<"objective" | "bound", (number | null)[]>;
};

/** A column of the legs of all robots, robot by robot. */
export type LegColumn = "gap" | "wait" | "turn" | "run" | "towards" | "metres" | "whole" | "jump";

/** How many packing stations there are, and what each has; whether orders have boxes until they are picked, or packed. */
export type ToldPacking = { stations: number; boxes: number; packers: number; sorters: number; until_picked: boolean };

/** A run as the page is told it. */
export type ToldRun = {
  name: string;
  status: string;
  tick: number;
  begin?: number;
  picked?: [number, number, number][];
  seed: number | null;
  rules: Record<string, string>;
  about: Record<string, string>;
  metrics: [string, string][];
  says: string[];
  layout: { width: number; height: number; kind: string; queues: number[][]; packing?: number[] };
  motion: Motion;
  skus: string[];
  orders: { name: string[]; lines_n: number[]; lines: number[]; due?: (number | null)[]; priority?: number[] };
  pods: { name: string[]; contents_n: number[]; contents: number[]; cell: number[]; robot: number[]; bound_for: number[][] };
  robots: { cell: number[]; heading: number[] };
  stations: { name: string[]; capacity: number[]; counts_orders: boolean[]; bundle_capacity: number[] };
  packing: ToldPacking | null;
  blocked: number[];
  legs: Record<"n" | LegColumn, number[]>;
  events: ToldEvents;
  order: string;
  texts: string[];
  charges: { n: number[]; tick: number[]; charge: number[] };
  decisions: (Record<"tick" | "decides" | "rule" | "backlog" | "parts" | "what" | "one" | "other", number[]> & { texts: string[] }) | null;
};

/** Metres per second squared, metres per second. */
export type Motion = { acceleration: number; speed: number };

// What unpack.mjs makes of it

export type EventName = keyof ToldEvents;

/** A column with times from the start of the run, or with texts. */
type Unpacked<Name, Column> = Name extends "tick" | "start_tick" | "picker_free_tick"
  ? Float64Array
  : Name extends "decides" | "rule" | "status" | "name"
    ? string[]
    : Column;

type Made<Columns> = { [Name in keyof Columns]: Unpacked<Name, Columns[Name]> };

export type Events = { [Name in EventName]: Made<ToldEvents[Name]> } & { visit_ended: { robot: number[] } };

/** The columns that several kinds of events have: all that is known of an event of any kind. */
export type EventColumns = { tick: Float64Array; start_tick?: Float64Array } & Partial<Record<Kind | "cell", number[]>>;

/** The events of all kinds in order: of each its kind (an index of `names`), its index among those of its kind, and its time. */
export type Sequence = { n: number; names: EventName[]; kind: Uint8Array; index: Int32Array; tick: Float64Array };

/** The legs of a robot: where and when each starts; and where the robot is before the first. */
export type Legs = { n: number; x0: number; y0: number; heading0: number } & Record<
  "start" | "wait" | "turn" | "run" | "towards" | "metres" | "whole" | "x" | "y",
  Float64Array
>;

/** Charge over time, as a share: a straight line from point to point. */
export type ChargeLine = { tick: Float64Array; charge: Float64Array };

/** Recorded decisions; the parts of decision `k` are those from `at[k]` up to `at[k + 1]`. */
export type Decisions = {
  tick: Float64Array;
  decides: string[];
  rule: string[];
  backlog: number[];
  at: Int32Array;
  what: number[];
  one: number[];
  other: number[];
};

/** A pair: a SKU and its number of items; -1 for a stock that never runs out. */
export type SkuItems = [number, number];

export type Run = Omit<ToldRun, "legs" | "events" | "decisions" | "charges"> & {
  legs: Legs[];
  events: Events;
  sequence: Sequence;
  decisions: Decisions | null;
  charges: ChargeLine[] | null;
  lines: SkuItems[][];
  contents: SkuItems[][];
};

// What the other modules make of that

/** Kinds of things that have a history. */
export type Kind = "robot" | "pod" | "station" | "order" | "bundle";

/** Something that can be selected: its id, that of a packing station, or the cell of a charger. */
export type Thing = { kind: Kind | "charger" | "packing"; id: number };

/** Of each thing of each kind the events that concern it, as indices of the sequence. */
export type History = Record<Kind, number[][]>;

/** What is at a packing station: totes on their way there, tasks that wait, orders that are being packed, and were. */
export type PackingNow = { coming: number; waiting: number; packing: number; packed: number };

/** An order that is not packed: its packing station, its box there (-1: none), items in it, and whether it is being packed. */
export type Packed = { station: number; box: number; items: number; begun: boolean };

/** Where a robot is; `leg` is -1 before its first. */
export type Position = { x: number; y: number; heading: number; moving: boolean; leg: number };

/** What a robot is at: the pod and the station it is about (-1: none), since when, and the cell it goes to or is at. */
export type Phase = {
  phase:
    | ("idle" | "to_pod" | "lifting" | "to_station" | "moving" | "to_rest")
    | ("charging" | "queue" | "station" | "storing" | "setting_down");
  pod: number;
  station: number;
  since: number;
  cell?: number;
};

export type HeatName = "waiting" | "traffic" | "picks" | "storage";
export type HeatKind = { label: string; unit: string; by: "cell" | "pod"; says: string };

/** The figures of a heat map, by cell or by pod, and the largest. */
export type Heat = HeatKind & { values: Float64Array; most: number };

/** The series of a time line, in bins of `width` ticks, and the times of decisions. */
export type Series = { width: number; perHour: Float64Array; backlog: Float64Array; rounds: Float64Array; events: Float64Array; first: number };

export type ColourName =
  | ("ink" | "soft" | "line" | "floor" | "place" | "lane" | "robot" | "idle" | "work" | "rest")
  | ("accent" | "wait" | "card" | "empty" | "charge" | "bundle" | "moved");
export type Palette = Record<ColourName, string> & { levels: string[]; heats: string[] };

/** The elements of a view. */
export type Figure = { canvas: HTMLCanvasElement; timeline: HTMLCanvasElement; caption: HTMLElement; numbers: HTMLElement };

/** A run with everything that shows it; `distance` says how many metres robots have driven by a time. */
export type View = {
  run: Run;
  history: History;
  edges: number[];
  letter: string;
  title: string;
  heats: Map<HeatName, Heat>;
  names: Names;
  world: World;
  scene: Scene;
  timeline: Timeline;
  figure: Figure;
  distance: (tick: number) => number;
};

/** What `make` takes as a child: text or an element; null for nothing. */
export type Child = Node | string | null;

/** A row of facts: its name, and a value for each run. */
export type Row = [string, ...(Node | string)[]];
