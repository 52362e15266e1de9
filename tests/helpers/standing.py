"""A pod that stands at a station."""

from rmfs_core.warehouse import Warehouse


def put_at_station(world: Warehouse, pod_id: int, station_id: int = 0) -> None:
    pod, station = world.pods[pod_id], world.stations[station_id]
    world.place_at_station(next(robot for robot in world.robots if robot.idle), pod, station)
