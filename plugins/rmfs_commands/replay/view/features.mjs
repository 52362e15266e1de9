// @ts-check
// What there is in some warehouses only.

/** @import { Run } from "./types.d.ts" */

/**
 * What there is in a run besides orders, pods, robots and picking stations.
 * @param {Run} run
 */
export function featuresOf(run) {
  const { events, stations, layout } = run;
  return {
    bundles: stations.bundle_capacity.some(Boolean),
    storing: stations.capacity.some((capacity, i) => !capacity && stations.bundle_capacity[i] > 0),
    chargers: layout.kind.includes("5"),
    maintenance: layout.kind.includes("6"),
    down: [events.robot_down, events.station_down, events.charger_down].some(({ tick }) => tick.length > 0),
    closed: events.station_closed.tick.length > 0,
    moves: events.pod_move_decided.tick.length > 0,
    packing: run.packing !== null,
  };
}
