import numpy as np
from attrs import define
from rmfs_core import *
from rmfs_core.hookspecs import hookimpl

@define
class RandomLocation:
    @hookimpl
    def choose_storage_location(self, warehouse, pod):
        t=warehouse.travel.times_from(pod.cell,warehouse.robots[pod.robot].heading,True)
        f=np.array(warehouse.free_storage_locations); return int(f[t[f].argmin()])
