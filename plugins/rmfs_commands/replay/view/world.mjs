// What is where at a time, apart from robots on their way: told from the events, first to last.

import { between } from "./motion.mjs";

/** State of an order. */
export const ORDER = { ABSENT: 0, WAITING: 1, PARTLY: 2, ASSIGNED: 3, DONE: 4 };

/** The warehouse at `tick`; `go` takes it to another time, backwards too. */
export class World {
  constructor(run) {
    this.run = run;
    this.openOn = new Int32Array(run.pods.name.length);
    this.handlers = run.sequence.names.map((name) => this[name]?.bind(this));
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
    this.unassigned = Int32Array.from(this.left);
    this.backlog = this.done = this.picks = this.visits = this.moves = 0;
    this.bundles = []; // by id, as far as they have arrived
    this.waitingBundles = new Set(); // those that no station has been assigned
    this.stored = 0;
    this.closed = new Set();
    this.onDuty = run.robots.cell.length;
    this.changed = true;
  }

  lineAtStart(station) {
    const { pods, layout } = this.run;
    const cells = layout.queues[station];
    const there = pods.cell.map((_, pod) => pod).filter((pod) => pods.robot[pod] >= 0 && cells.includes(pods.cell[pod]));
    return there.sort((a, b) => cells.indexOf(pods.cell[a]) - cells.indexOf(pods.cell[b]));
  }

  /** Go to a time: everything that has happened by then has happened. */
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

  /** How full a robot's battery is, as a share; null without one. */
  charge(robot) {
    return this.run.charges ? between(this.run.charges[robot], this.tick) : null;
  }

  // Events, by their names in a trace; `i` is their place among those of their kind.

  order_arrived(i) {
    const order = this.run.events.order_arrived.order[i];
    this.orders[order] = ORDER.WAITING;
    this.backlog++;
    for (const [sku, quantity] of this.run.lines[order]) this.demand[sku] += quantity;
  }

  order_assigned(i) {
    const { order, station, items, complete } = this.run.events.order_assigned;
    const { open } = this.stations[station[i]];
    open.set(order[i], (open.get(order[i]) ?? 0) + items[i]);
    this.stations[station[i]].items += items[i];
    this.unassigned[order[i]] -= items[i];
    this.orders[order[i]] = complete[i] ? ORDER.ASSIGNED : ORDER.PARTLY;
    if (complete[i]) this.backlog--;
  }

  pod_lifted(i) {
    const { pod, robot } = this.run.events.pod_lifted;
    this.podCell[pod[i]] = -1;
    this.podRobot[pod[i]] = robot[i];
    this.robotPod[robot[i]] = pod[i];
  }

  pod_stored(i) {
    const { pod, robot, cell } = this.run.events.pod_stored;
    this.podCell[pod[i]] = cell[i];
    this.podRobot[pod[i]] = -1;
    this.robotPod[robot[i]] = -1;
  }

  queue_joined(i) {
    const { pod, station } = this.run.events.queue_joined;
    const { line } = this.stations[station[i]];
    if (!line.includes(pod[i])) line.push(pod[i]);
  }

  visit_started(i) {
    const { pod, station, robot } = this.run.events.visit_started;
    const { line } = this.stations[station[i]];
    if (!line.includes(pod[i])) line.unshift(pod[i]);
    this.stations[station[i]].visit = { pod: pod[i], robot: robot[i] };
    this.visits++;
  }

  visit_ended(i) {
    const { pod, station } = this.run.events.visit_ended;
    const own = this.stations[station[i]];
    own.line = own.line.filter((one) => one !== pod[i]);
    own.visit = null;
  }

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
    const stock = this.stock[pod[i]].get(sku[i]);
    if (stock > 0) this.stock[pod[i]].set(sku[i], stock - 1);
  }

  bundle_arrived() {
    this.waitingBundles.add(this.bundles.push({ station: -1, pod: -1, stored: false }) - 1);
  }

  bundle_assigned(i) {
    const { bundle, station } = this.run.events.bundle_assigned;
    this.bundles[bundle[i]].station = station[i];
    this.waitingBundles.delete(bundle[i]);
    this.stations[station[i]].bundles.add(bundle[i]);
  }

  bundle_bound(i) {
    const { bundle, pod } = this.run.events.bundle_bound;
    this.bundles[bundle[i]].pod = pod[i];
  }

  bundle_stored(i) {
    const { bundle, station, pod, sku, items } = this.run.events.bundle_stored;
    this.bundles[bundle[i]].stored = true;
    this.stored++;
    this.stations[station[i]].bundles.delete(bundle[i]);
    const stock = this.stock[pod[i]];
    if (!(stock.get(sku[i]) < 0)) stock.set(sku[i], (stock.get(sku[i]) ?? 0) + items[i]);
  }

  station_opened(i) {
    this.closed.delete(this.run.events.station_opened.station[i]);
  }

  station_closed(i) {
    this.closed.add(this.run.events.station_closed.station[i]);
  }

  robots_on_duty(i) {
    this.onDuty = this.run.events.robots_on_duty.number[i];
  }

  pod_move_decided() {
    this.moves++;
  }

  order_completed(i) {
    this.orders[this.run.events.order_completed.order[i]] = ORDER.DONE;
    this.done++;
  }
}
