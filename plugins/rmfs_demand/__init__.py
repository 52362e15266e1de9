import numpy as np
from attrs import define
from rmfs_core import *
from rmfs_core.hookspecs import hookimpl

@define
class Demand:
    @hookimpl
    def select_pods(self, warehouse, max_fetches):
        D=warehouse.open_demand(); out=[]
        unc={s.id:{r.sku for r in s.uncovered_requests} for s in warehouse.stations}
        inb={s.id:len(s.inbound_pods) for s in warehouse.stations}
        free={p.id:p for p in warehouse.free_pods}; leav={p.id:p for p in warehouse.leaving_pods}
        while True:
            todo=[s for s in unc if unc[s]]
            if not todo: return out
            todo.sort(key=lambda s:(inb[s],-len(unc[s]),s))
            done=False
            for s in todo:
                T=warehouse.travel.times_to(warehouse.stations[s].cell,True)
                cand=[p for p in list(leav.values())+(list(free.values()) if max_fetches else []) if any(k in unc[s] for k in p.contents) and s not in p.bound_for]
                if not cand: continue
                p=min(cand,key=lambda p:(-sum(min(D[k],p.contents[k]) for k in p.contents),T[p.cell].min(),p.id))
                if p.id in leav: del leav[p.id]
                else: del free[p.id]; max_fetches-=1
                unc[s]-=set(p.contents); inb[s]+=1
                out.append(PodTrip(p.id,s)); done=True; break
            if not done: return out
