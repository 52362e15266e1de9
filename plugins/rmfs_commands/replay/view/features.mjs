// What there is in some warehouses only.

/** What there is in a run besides orders, pods, robots and picking stations. */
export function featuresOf(run) {
  const { events, stations, layout } = run;
  return {
    bundles: stations.bundle_capacity?.some(Boolean) ?? false,
    storing: stations.capacity.some((capacity, i) => !capacity && stations.bundle_capacity?.[i]),
    chargers: layout.kind.includes("5"),
    closed: Boolean(events.station_closed?.tick.length),
    moves: Boolean(events.pod_move_decided?.tick.length),
  };
}
