"""The OpenAPI document of halls: facts and commands, each with its fields."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from rmfs_commands.serve.openapi import OBJECT, TEXT, in_json, refusals
from rmfs_commands.session.facts import FACTS, MOST_EVENTS

NUMBER, WHOLE = {"type": "number"}, {"type": "integer"}
TEXTS = {"type": "array", "items": TEXT}
FIELDS: Mapping[str, Mapping[str, Any]] = {
    **dict.fromkeys(("order", "station", "robot", "pod", "sku", "bundle", "packing"), TEXT),
    **dict.fromkeys(("cell", "part", "items", "tote"), WHOLE),
    "box": {**WHOLE, "nullable": True},
    "skus": TEXTS,
    "charge": NUMBER,
}
COMMANDS = {
    "assign": ("order", "station", "skus", "part"),
    "fetch": ("robot", "pod", "station"),
    "lift": ("robot", "pod"),
    "go_on": ("robot", "pod", "station"),
    "store": ("robot", "pod", "cell"),
    "pick_next": ("station", "pod", "order", "sku"),
    "store_bundle": ("station", "pod", "bundle"),
    "assign_bundle": ("bundle", "station"),
    "reorder": ("sku", "items"),
    "assign_packing": ("order", "packing", "box"),
    "send_part": ("order", "tote", "station", "packing", "items"),
    "put_next": ("packing", "order", "tote"),
    "pack_next": ("packing", "order"),
    "move_robot": ("robot", "cell", "charge"),
    "move_pod": ("robot", "pod", "cell"),
}
"""Commands and their fields."""


def openapi_of_halls() -> dict[str, Any]:
    """Return the document (OpenAPI 3.0)."""
    hall = {"name": "hall", "in": "path", "required": True, "schema": TEXT}
    after = {"name": "after", "in": "query", "schema": WHOLE, "description": "Number of the last batch that is known"}
    wait = {"name": "wait_s", "in": "query", "schema": NUMBER, "description": "Seconds to wait for the next batch"}
    match = {"name": "If-Match", "in": "header", "schema": TEXT, "description": "Number of the last batch"}
    stream = {"text/event-stream": {"schema": TEXT}}
    answers = in_json("Answers")
    answers["content"] |= stream
    one: dict[str, Any] = {
        "parameters": [hall],
        "post": _asked("Make a hall of the tables of a scenario", "201", in_json("Made"), "Make"),
        "get": _asked("The whole state, as `rmfs decide` reads it", "200", in_json("State")),
        "put": _asked("Replace the whole state", "200", in_json("Answer"), "State")
        | {"parameters": [{**match, "required": True}]},
        "delete": _asked("End a hall", "200", in_json("Seq")) | {"parameters": [match]},
    }
    paths = {
        "/v1/halls": {"get": _asked("Names of the halls", "200", in_json("Names"))},
        "/v1/halls/{hall}": one,
        "/v1/halls/{hall}/events": {
            "parameters": [hall],
            "post": _asked("Facts in, commands out", "200", in_json("Answer"), "Batch"),
        },
        "/v1/halls/{hall}/commands": {
            "parameters": [hall, after, wait],
            "get": _asked("Answers after a batch, for callers that have missed them", "200", answers),
        },
    }
    about = {"title": "rmfs serve --hall", "version": version("rmfs"), "description": "Halls that run in sessions."}
    return {"openapi": "3.0.3", "info": about, "paths": paths, "components": {"schemas": _schemas()}}


def _asked(summary: str, status: str, answer: Mapping[str, Any], body: str | None = None) -> dict[str, Any]:
    told = {
        "400": "This is no JSON",
        "404": "There is no such hall",
        "408": "The request took too long to arrive",
        "409": "`after` or If-Match is not the last batch, whose number is in `seq`; or there is such a hall already",
        "413": "The request is too long",
        "415": "The request is not of the type application/json",
        "421": "The request's header Host names a host that is not served here",
        "422": "The request is wrong; `place` says where",
        "500": "A rule failed; nothing has changed",
        "503": "Too many requests are waiting, or the hall is being started again",
        "504": "The answer took too long; send the batch again",
    }
    asked = {"requestBody": {"required": True, **in_json(body)}} if body else {}
    return {"summary": summary, **asked, "responses": {status: {"description": "Done", **answer}, **refusals(told)}}


def _schemas() -> dict[str, Any]:
    facts = {f"fact_{kind}": _fact(kind) for kind in FACTS}
    commands = {
        f"command_{kind}": _object(
            {"command": WHOLE, "kind": {"enum": [kind]}, **{name: FIELDS[name] for name in names}}
        )
        for kind, names in COMMANDS.items()
    }
    dropped = _object({"id": TEXT, "place": TEXT, "problem": TEXT})
    overdue = _object({"awaits": TEXT, "since_s": NUMBER}) | {"additionalProperties": TEXT}
    answer = {
        "seq": WHOLE,
        "time_s": NUMBER,
        "commands": _list(_one_of(commands)),
        "dropped": _list(dropped),
        "overdue": _list(overdue),
        "ask_again_s": NUMBER | {"nullable": True},
    }
    events = _list(_one_of(facts)) | {"maxItems": MOST_EVENTS}
    return {
        **facts,
        **commands,
        "Batch": _object({"after": WHOLE, "time_s": NUMBER, "events": events}),
        "Answer": _answer(answer),
        "Answers": _object({"seq": WHOLE, "answers": _list({"$ref": "#/components/schemas/Answer"})}),
        "Make": _object({"scenario": OBJECT}),
        "Made": _object({"session": TEXT, "seq": WHOLE}),
        "Names": _object({"halls": TEXTS}),
        "Seq": _object({"seq": WHOLE}),
        "State": OBJECT,
        "Problem": _object({"title": TEXT, "status": WHOLE, "detail": TEXT}) | {"description": "RFC 9457"},
    }


def _answer(needed: Mapping[str, Any]) -> dict[str, Any]:
    answer = _object(needed)
    replaced = {"type": "boolean", "description": "The state was replaced; no command before counts"}
    left_out = TEXTS | {"description": "Orders that waited for their turn, and are not in the new state"}
    answer["properties"] |= {"replaced": replaced, "left_out": left_out}
    return answer


def _fact(kind: str) -> dict[str, Any]:
    needed, optional = FACTS[kind]
    fields = {name: told.schema for name, told in needed.items()}
    fact = _object({"id": TEXT, "kind": {"enum": [kind]}, **fields})
    fact["properties"] |= {name: told.schema for name, told in optional.items()}
    return fact


def _object(properties: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": dict(properties), "required": [*properties]}


def _list(items: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


def _one_of(schemas: Mapping[str, Any]) -> dict[str, Any]:
    return {"oneOf": [{"$ref": f"#/components/schemas/{name}"} for name in schemas]}
