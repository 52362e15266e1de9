// @ts-check
// What is where at a time, apart from robots on their way: told from the events, first to last.

import { between, lastUpTo } from "./motion.mjs";
/** @import { EventName, Packed, PackingNow, Run } from "./types.d.ts" */

/** State of an order. */
export const ORDER = { ABSENT: 0, WAITING: 1, PARTLY: 2, ASSIGNED: 3, DONE: 4, CANCELLED: 5 };

/**
 * A station: pods in its line, the visit that goes on, items to pick of each open order and of all, bundles to store.
 * @typedef {{ line: number[], visit: { pod: number, robot: number } | null, open: Map<number, number>, items: number, bundles: Set<number> }} StationNow
 */

/** The warehouse at `tick`; `go` takes it to another time, backwards too. */
export class World {
  tick = -1;
  next = 0; // index of the next event
  podCell = new Int32Array();
  podRobot = new Int32Array();
  robotPod = new Int32Array();
  demand = new Int32Array();
  /** @type {Map<number, number>[]} */
  stock = []; // by pod
  /** @type {StationNow[]} */
  stations = [];
  orders = new Uint8Array();
  left = new Int32Array(); // items of each order to pick,
  unassigned = new Int32Array(); // and to assign
  backlog = 0;
  done = 0;
  cancelled = 0;
  picks = 0;
  visits = 0;
  moves = 0;
  /** @type {{ station: number, pod: number, stored: boolean }[]} */
  bundles = []; // by id, as far as they have arrived
  /** @type {Set<number>} */
  waitingBundles = new Set(); // those that no station has been assigned
  stored = 0;
  /** @type {Set<number>} */
  closed = new Set();
  /** @type {Set<number>} */
  robotsDown = new Set();
  /** @type {Set<number>} */
  stationsDown = new Set();
  /** @type {Set<number>} */
  chargersDown = new Set(); // cells
  onDuty = 0;
  /** @type {PackingNow[]} */
  packing = []; // by packing station
  /** @type {Map<number, Packed>} */
  packs = new Map(); // by order
  changed = true;

  /** @param {Run} run */
  constructor(run) {
    this.run = run;
    this.openOn = new Int32Array(run.pods.name.length);
    /** @type {Partial<Record<EventName, (i: number) => void>>} */
    const methods = this;
    this.puts = putTimes(run);
    this.handlers = run.sequence.names.map((name) => methods[name]?.bind(this));
    this.reset();
  }

  reset() {
    const { run } = this;
    this.tick = -1;
    this.next = 0;
    this.podCell = Int32Array.from(run.pods.cell, (cell, pod) => (run.pods.robot[pod] < 0 ? cell : -1));
    this.podRobot = Int32Array.from(run.pods.robot);
    this.robotPod = new Int32Array(run.robots.cell.length).fill(-1);
    this.podRobot.forEach((robot, pod) => robot >= 0 && (this.robotPod[robot] = pod));
    this.demand = new Int32Array(run.skus.length);
    this.stock = run.contents.map((contents) => new Map(contents));
    this.stations = run.stations.name.map((_, i) => ({ line: this.lineAtStart(i), visit: null, open: new Map(), items: 0, bundles: new Set() }));
    this.orders = new Uint8Array(run.orders.name.length);
    this.left = Int32Array.from(run.lines, (lines) => lines.reduce((sum, [, quantity]) => sum + quantity, 0));
    for (const [order, sku, items] of run.picked ?? []) {
      this.left[order] -= items; // before the run
      this.demand[sku] -= items;
    }
    this.unassigned = Int32Array.from(this.left);
    this.backlog = this.done = this.cancelled = this.picks = this.visits = this.moves = 0;
    this.bundles = [];
    this.waitingBundles = new Set();
    this.stored = 0;
    this.closed = new Set();
    this.robotsDown = new Set();
    this.stationsDown = new Set();
    this.chargersDown = new Set();
    this.onDuty = run.robots.cell.length;
    this.packing = Array.from({ length: run.packing?.stations ?? 0 }, () => ({ coming: 0, waiting: 0, packing: 0, packed: 0 }));
    this.packs = new Map();
    this.changed = true;
  }

  /** @param {number} station */
  lineAtStart(station) {
    const { pods, layout } = this.run;
    const cells = layout.queues[station];
    const there = pods.cell.map((_, pod) => pod).filter((pod) => pods.robot[pod] >= 0 && cells.includes(pods.cell[pod]));
    return there.sort((a, b) => cells.indexOf(pods.cell[a]) - cells.indexOf(pods.cell[b]));
  }

  /**
   * Go to a time: everything that has happened by then has happened.
   * @param {number} tick
   */
  go(tick) {
    if (tick < this.tick) this.reset();
    const { kind, index, tick: ticks, n } = this.run.sequence;
    while (this.next < n && ticks[this.next] <= tick) {
      this.handlers[kind[this.next]]?.(index[this.next]);
      this.next++;
      this.changed = true;
    }
    this.tick = tick;
    return this;
  }

  /** Items on each pod that orders wait for: of orders that have arrived, not picked yet. */
  openItems() {
    if (this.changed) {
      this.changed = false;
      this.stock.forEach((stock, pod) => {
        let sum = 0;
        for (const [sku, number] of stock) {
          if (!this.demand[sku]) continue;
          sum += number < 0 ? this.demand[sku] : Math.min(this.demand[sku], number);
        }
        this.openOn[pod] = sum;
      });
    }
    return this.openOn;
  }

  /**
   * How full a robot's battery is, as a share; null without one.
   * @param {number} robot
   */
  charge(robot) {
    return this.run.charges ? between(this.run.charges[robot], this.tick) : null;
  }

  /**
   * How many totes are being put into boxes at a packing station.
   * @param {number} station
   */
  putting(station) {
    const { start, end } = this.puts[station];
    return lastUpTo(start, this.tick) - lastUpTo(end, this.tick);
  }

  /**
   * Orders that have a box at a packing station, by the number of the box.
   * @param {number} station
   */
  boxes(station) {
    const held = [...this.packs].filter(([order, { station: at, box }]) => at === station && box >= 0 && !(this.run.packing?.until_picked && this.orders[order] === ORDER.DONE));
    return new Map(held.map(([order, { box }]) => /** @type {[number, number]} */ ([box, order])).sort(([a], [b]) => a - b));
  }

  // Events, by their names in a trace; `i` is their index among those of their kind.

  /** @param {number} i */
  order_arrived(i) {
    const order = this.run.events.order_arrived.order[i];
    this.orders[order] = ORDER.WAITING;
    this.backlog++;
    for (const [sku, quantity] of this.run.lines[order]) this.demand[sku] += quantity;
  }

  /** @param {number} i */
  order_assigned(i) {
    const { order, station, items, complete } = this.run.events.order_assigned;
    const { open } = this.stations[station[i]];
    open.set(order[i], (open.get(order[i]) ?? 0) + items[i]);
    this.stations[station[i]].items += items[i];
    this.unassigned[order[i]] -= items[i];
    this.orders[order[i]] = complete[i] ? ORDER.ASSIGNED : ORDER.PARTLY;
    if (complete[i]) this.backlog--;
  }

  /** @param {number} i */
  order_cancelled(i) {
    const order = this.run.events.order_cancelled.order[i];
    this.orders[order] = ORDER.CANCELLED;
    this.backlog--;
    this.cancelled++;
    for (const [sku, quantity] of this.run.lines[order]) this.demand[sku] -= quantity;
  }

  /** @param {number} i */
  pod_lifted(i) {
    const { pod, robot } = this.run.events.pod_lifted;
    this.podCell[pod[i]] = -1;
    this.podRobot[pod[i]] = robot[i];
    this.robotPod[robot[i]] = pod[i];
  }

  /** @param {number} i */
  pod_stored(i) {
    const { pod, robot, cell } = this.run.events.pod_stored;
    this.podCell[pod[i]] = cell[i];
    this.podRobot[pod[i]] = -1;
    this.robotPod[robot[i]] = -1;
  }

  /** @param {number} i */
  queue_joined(i) {
    const { pod, station } = this.run.events.queue_joined;
    const { line } = this.stations[station[i]];
    if (!line.includes(pod[i])) line.push(pod[i]);
  }

  /** @param {number} i */
  visit_started(i) {
    const { pod, station, robot } = this.run.events.visit_started;
    const { line } = this.stations[station[i]];
    if (!line.includes(pod[i])) line.unshift(pod[i]);
    this.stations[station[i]].visit = { pod: pod[i], robot: robot[i] };
    this.visits++;
  }

  /** @param {number} i */
  visit_ended(i) {
    const { pod, station } = this.run.events.visit_ended;
    const own = this.stations[station[i]];
    own.line = own.line.filter((one) => one !== pod[i]);
    own.visit = null;
  }

  /** @param {number} i */
  item_picked(i) {
    const { pod, station, order, sku } = this.run.events.item_picked;
    const own = this.stations[station[i]];
    const left = (own.open.get(order[i]) ?? 1) - 1;
    if (left > 0) own.open.set(order[i], left);
    else own.open.delete(order[i]);
    own.items--;
    this.left[order[i]]--;
    this.demand[sku[i]]--;
    this.picks++;
    const stock = this.stock[pod[i]].get(sku[i]) ?? 0;
    const before = this.run.begin !== undefined && this.run.events.item_picked.tick[i] <= this.run.begin;
    if (stock > 0 && !before) this.stock[pod[i]].set(sku[i], stock - 1);
  }

  bundle_arrived() {
    this.waitingBundles.add(this.bundles.push({ station: -1, pod: -1, stored: false }) - 1);
  }

  /** @param {number} i */
  bundle_assigned(i) {
    const { bundle, station } = this.run.events.bundle_assigned;
    this.bundles[bundle[i]].station = station[i];
    this.waitingBundles.delete(bundle[i]);
    this.stations[station[i]].bundles.add(bundle[i]);
  }

  /** @param {number} i */
  bundle_bound(i) {
    const { bundle, pod } = this.run.events.bundle_bound;
    this.bundles[bundle[i]].pod = pod[i];
  }

  /** @param {number} i */
  bundle_stored(i) {
    const { bundle, station, pod, sku, items } = this.run.events.bundle_stored;
    this.bundles[bundle[i]].stored = true;
    this.stored++;
    this.stations[station[i]].bundles.delete(bundle[i]);
    const stock = this.stock[pod[i]];
    const before = stock.get(sku[i]) ?? 0;
    if (before >= 0) stock.set(sku[i], before + items[i]);
  }

  /** @param {number} i */
  station_opened(i) {
    this.closed.delete(this.run.events.station_opened.station[i]);
  }

  /** @param {number} i */
  station_closed(i) {
    this.closed.add(this.run.events.station_closed.station[i]);
  }

  /** @param {number} i */
  robot_down(i) {
    this.robotsDown.add(this.run.events.robot_down.robot[i]);
  }

  /** @param {number} i */
  robot_up(i) {
    this.robotsDown.delete(this.run.events.robot_up.robot[i]);
  }

  /** @param {number} i */
  station_down(i) {
    this.stationsDown.add(this.run.events.station_down.station[i]);
  }

  /** @param {number} i */
  station_up(i) {
    this.stationsDown.delete(this.run.events.station_up.station[i]);
  }

  /** @param {number} i */
  charger_down(i) {
    this.chargersDown.add(this.run.events.charger_down.cell[i]);
  }

  /** @param {number} i */
  charger_up(i) {
    this.chargersDown.delete(this.run.events.charger_up.cell[i]);
  }

  /** @param {number} i */
  robots_on_duty(i) {
    this.onDuty = this.run.events.robots_on_duty.number[i];
  }

  pod_move_decided() {
    this.moves++;
  }

  /** @param {number} i */
  order_completed(i) {
    this.orders[this.run.events.order_completed.order[i]] = ORDER.DONE;
    this.done++;
  }

  /** @param {number} i */
  packing_assigned(i) {
    const { order, packing, box } = this.run.events.packing_assigned;
    this.packs.set(order[i], { station: packing[i], box: box[i], items: 0, begun: false });
  }

  /** @param {number} i */
  part_sent(i) {
    this.packing[this.run.events.part_sent.packing[i]].coming++;
  }

  /** @param {number} i */
  part_arrived(i) {
    const own = this.packing[this.run.events.part_arrived.packing[i]];
    own.coming--;
    own.waiting++;
  }

  /** @param {number} i */
  part_put(i) {
    const { order, packing, items } = this.run.events.part_put;
    const pack = this.packs.get(order[i]);
    if (pack) pack.items += items[i];
    this.packing[packing[i]].waiting--;
  }

  /** @param {number} i */
  order_consolidated(i) {
    this.packing[this.run.events.order_consolidated.packing[i]].waiting++;
  }

  /** @param {number} i */
  packing_started(i) {
    const { order, packing } = this.run.events.packing_started;
    const pack = this.packs.get(order[i]);
    if (pack) pack.begun = true;
    this.packing[packing[i]].waiting--;
    this.packing[packing[i]].packing++;
  }

  /** @param {number} i */
  order_packed(i) {
    const { order, packing } = this.run.events.order_packed;
    this.packs.delete(order[i]);
    this.packing[packing[i]].packing--;
    this.packing[packing[i]].packed++;
  }
}

/**
 * When totes began to be put into boxes, and when that ended, by packing station, each ascending.
 * @param {Run} run
 */
function putTimes({ packing, events: { part_put: put } }) {
  return Array.from({ length: packing?.stations ?? 0 }, (_, station) => {
    const own = put.packing.flatMap((at, i) => (at === station ? [i] : []));
    const end = own.map((i) => put.tick[i]);
    return { start: own.map((i) => put.start_tick[i]).sort((a, b) => a - b), end };
  });
}
