import numpy as np
from attrs import define
from rmfs_core import *
from rmfs_core.hookspecs import hookimpl

@define
class NearestRobot:
    @hookimpl
    def assign_tasks(self, warehouse):
        idle=list(warehouse.idle_robots); out=[]
        for p in warehouse.waiting_pods:
            if not idle: break
            t=warehouse.travel.times_to(p.cell,False)
            r=min(idle,key=lambda r:(t[r.cell,r.heading],r.id)); idle.remove(r); out.append(TaskAssignment(r.id,p.id))
        return out
