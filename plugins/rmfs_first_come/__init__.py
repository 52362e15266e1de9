import numpy as np
from attrs import define
from rmfs_core import *
from rmfs_core.hookspecs import hookimpl

@define
class FirstCome:
    @hookimpl
    def assign_orders(self, warehouse):
        out=[]; free={s.id:s.free_capacity for s in warehouse.stations}; load={s.id:s.load for s in warehouse.stations}
        avail=warehouse.available(); L=warehouse.backlog_lines; bl=warehouse.backlog
        if not bl: return out
        sc=np.stack([np.bincount(L.order,weights=np.minimum(L.quantity,avail[s][L.sku]),minlength=len(bl)) for s in free])
        size=np.array([o.open_items for o in bl]); alive=np.ones(len(bl),bool)
        while True:
            best=None
            for s in free:
                ok=alive&(size<=free[s])
                if not ok.any(): continue
                v=np.where(ok,sc[s],-1); i=int(v.argmax())
                k=(-v[i],i,load[s],s)
                if best is None or k<best: best=k
            if best is None: return out
            _,i,_,s=best; alive[i]=False; free[s]-=size[i]; load[s]+=size[i]
            out.append(OrderAssignment(bl[i].id,s))
