"""Decisions of rules: the one vocabulary of scenarios, people and hooks."""

from __future__ import annotations

from enum import StrEnum


class Role(StrEnum):
    """A decision of a rule in a run; an observer decides nothing. As a text it is its name in code: ``"poa_pps"``.

    Attributes
    ----------
    label
        Name for people, in traces and recordings: ``"POA+PPS"``.
    hook
        The hook that a rule answers in this role. (An observer may implement the other observer hooks too.)
    what
        The decision in a few words.
    key
        Its key in the section ``rules`` of a scenario.
    many
        Whether any number of rules may play it: the key holds a list, ``"filters"`` or ``"observers"``.
    assigns
        Whether it assigns orders: each such decision is a period.
    """

    label: str
    hook: str
    what: str
    key: str
    many: bool
    assigns: bool

    def __new__(cls, value: str, label: str = "", hook: str = "", what: str = "", key: str = "") -> Role:
        """Make a member."""
        role = str.__new__(cls, value)
        role._value_ = value
        role.label, role.hook, role.what, role.key, role.many = label, hook, what, key or value, bool(key)
        role.assigns = hook.startswith("assign_orders")
        return role

    POA = "poa", "POA", "assign_orders", "orders to stations"
    PPS = "pps", "PPS", "select_pods", "pods to stations"
    POA_PPS = "poa_pps", "POA+PPS", "assign_orders_and_pods", "orders and pods to stations together"
    PR = "pr", "PR", "choose_storage_location", "where pods go back to"
    TA = "ta", "TA", "assign_tasks", "waiting pods to idle robots"
    PP = "pp", "PP", "plan_path", "paths of robots"
    ROA = "roa", "ROA", "assign_bundles", "bundles to replenishment stations"
    RPS = "rps", "RPS", "select_replenishment_pods", "bundles to pods"
    ROA_RPS = "roa_rps", "ROA+RPS", "assign_bundles_and_pods", "bundles to stations and pods together"
    ACTIVATE = "activate", "activation", "activate_stations", "which stations take orders"
    IDLE = "idle", "idle", "idle_robots", "where robots without a task rest and charge"
    MOVE = "move", "repositioning", "move_pods", "pods that robots without a task carry elsewhere"
    PACKING = "packing", "packing", "assign_packing", "packing stations of orders"
    PACKING_TASK = "packing_task", "packing-task", "choose_packing_task", "what a free packer does next"
    FILTER = "filter", "filter", "filter_backlog", "which orders the rule for POA sees", "filters"
    OBSERVER = "observer", "observer", "on_event", "nothing, it measures", "observers"

    @property
    def hooks(self) -> tuple[str, ...]:
        """The hooks of which one is answered in this role: paths may be planned for one robot or for all that ask."""
        return (self.hook, "plan_paths") if self is Role.PP else (self.hook,)

    @property
    def excludes(self) -> tuple[Role, ...]:
        """Roles that nobody plays where a rule plays this one: a joint rule decides what its parts are itself."""
        for joint, parts in ((Role.POA_PPS, (Role.POA, Role.PPS)), (Role.ROA_RPS, (Role.ROA, Role.RPS))):
            if self is joint or self in parts:
                return parts if self is joint else (joint,)
        return ()

    @classmethod
    def labelled(cls, label: str) -> Role:
        """Return the role of a label; raise `ValueError` where there is none."""
        for role in cls:
            if role.label == label:
                return role
        raise ValueError(f"no role is called {label!r}")
