"""The service's OpenAPI document, and the page that shows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

from attrs import fields

from rmfs_commands.cli.schema import schema_of
from rmfs_commands.serve.service import SMALL, Request
from rmfs_commands.states import state_schema
from rmfs_commands.states.written import WrittenAnswer

PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>rmfs serve</title>
<link rel="stylesheet" href="docs/files/swagger-ui.css">
<link rel="icon" href="docs/files/favicon-32x32.png">
<div id="page"></div>
<script src="docs/files/swagger-ui-bundle.js"></script>
<script>SwaggerUIBundle({ url: "openapi.json", dom_id: "#page", deepLinking: true });</script>
</html>
"""
"""Swagger UI, from files that the service has itself."""

TEXT, OBJECT = {"type": "string"}, {"type": "object"}


def openapi(rules: Sequence[str]) -> dict[str, Any]:
    """Return the document (OpenAPI 3.0, which the page can show) of a service with these rules."""
    told = {
        "400": "This is no JSON",
        "408": "The request took too long to arrive",
        "409": "`change` starts from another state than the last one kept, or none is kept: send the whole state",
        "413": "The request is too long",
        "415": "The request is not of the type application/json",
        "421": "The request's header Host names a host that is not served here; any path may answer so",
        "422": "The state is wrong; `place` says where",
        "500": "The rule failed, or decided something impossible",
        "503": "Too many requests are waiting, or the rules are being loaded again",
        "504": "The decision took too long",
    }
    responses = {"200": {"description": "The decision", **in_json("Answer")}, **refusals(told)}
    return {
        "openapi": "3.0.3",
        "info": {
            "title": "rmfs serve",
            "version": version("rmfs"),
            "description": f"Decisions for robotic mobile fulfillment systems. Rules: {', '.join(rules)}.",
        },
        "paths": {
            "/decide": {
                "post": {
                    "summary": "What a rule decides in a state",
                    "requestBody": {"required": True, **in_json("State", "Request", example=SMALL)},
                    "responses": responses,
                }
            },
            "/health": {
                "get": {
                    "summary": "Whether the rules are loaded",
                    "responses": {
                        "200": {"description": "They are", **in_json("Health")},
                        "503": {"description": "They are being loaded", **in_json("Health")},
                    },
                }
            },
            "/metrics": {
                "get": {
                    "summary": "Figures for Prometheus",
                    "responses": {"200": {"description": "Text format", "content": {"text/plain": {"schema": TEXT}}}},
                }
            },
        },
        "components": {"schemas": _schemas(rules)},
    }


def _schemas(rules: Sequence[str]) -> dict[str, Any]:
    state = _nullable(state_schema())
    del state["$schema"]
    kinds: dict[str, Any] = {
        "state": {"$ref": "#/components/schemas/State"},
        "change": OBJECT,
        "rule": TEXT | {"enum": [*rules]},
    }
    request = {
        field.name: {"description": field.metadata["doc"], "allOf": [kinds.get(field.name, TEXT)]}
        for field in fields(Request)
    }
    answer = _nullable(schema_of(WrittenAnswer, "Answer"))
    del answer["$schema"]
    problem = {"title": TEXT, "status": {"type": "integer"}, "detail": TEXT, "place": TEXT}
    return {
        "State": state,
        "Request": {"type": "object", "properties": request, "additionalProperties": False},
        "Answer": answer,
        "Health": {
            "type": "object",
            "properties": {
                "status": TEXT | {"enum": ["ok", "starting"]},
                "rules": {"type": "array", "items": TEXT},
            },
        },
        "Problem": {"type": "object", "properties": problem, "description": "RFC 9457"},
    }


def refusals(told: Mapping[str, str]) -> dict[str, Any]:
    """Return the responses that refuse something, by status."""
    problem = {"content": {"application/problem+json": {"schema": {"$ref": "#/components/schemas/Problem"}}}}
    return {code: {"description": said, **problem} for code, said in told.items()}


def in_json(*schemas: str, **more: Any) -> dict[str, Any]:
    """Return the content of a request or response: JSON of one of these schemas."""
    refs = [{"$ref": f"#/components/schemas/{name}"} for name in schemas]
    schema = refs[0] if len(refs) == 1 else {"oneOf": refs}
    return {"content": {"application/json": {"schema": schema, **more}}}


def _nullable(schema: Any) -> Any:
    """Return a JSON Schema as OpenAPI 3.0 has it, which knows no type null."""
    if isinstance(schema, list):
        return [_nullable(entry) for entry in schema]
    if not isinstance(schema, Mapping):
        return schema
    kinds = schema.get("anyOf", ())
    if {"type": "null"} in kinds:
        (kind,) = (kind for kind in kinds if kind != {"type": "null"})
        rest = {name: value for name, value in schema.items() if name != "anyOf"}
        return {**_nullable(kind), **_nullable(rest), "nullable": True}
    return {name: _nullable(value) for name, value in schema.items()}
