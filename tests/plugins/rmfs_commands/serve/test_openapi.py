"""The OpenAPI document."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rmfs_commands.serve.openapi import openapi
from rmfs_commands.serve.service import SMALL, Service

REFERENCE = Path(__file__).resolve().parents[4] / "docs" / "reference" / "service.md"


def test_the_reference_has_what_the_document_has() -> None:
    """Each key of a request, each status and each path."""
    text = REFERENCE.read_text(encoding="utf-8")
    document = openapi(["first-come"])
    for key in document["components"]["schemas"]["Request"]["properties"]:
        assert f"| `{key}` |" in text
    for status in document["paths"]["/decide"]["post"]["responses"].keys() - {"200"}:
        assert f"| {status} |" in text
    for path, methods in document["paths"].items():
        assert all(f"`{method.upper()} {path}`" in text for method in methods)


def parts(value: Any) -> Iterator[dict[str, Any]]:
    """Yield every object in it."""
    if isinstance(value, dict):
        yield value
        value = list(value.values())
    for entry in value if isinstance(value, list) else ():
        yield from parts(entry)


def test_it_holds_together() -> None:
    """Every reference leads somewhere, and no schema says what OpenAPI 3.0 does not know."""
    document = openapi(["first-come"])
    for part in parts(document):
        if reference := part.get("$ref"):
            assert reference.removeprefix("#/components/schemas/") in document["components"]["schemas"]
        assert part.get("type") != "null" and "$schema" not in part
    assert json.loads(json.dumps(document)) == document


@pytest.mark.parametrize("asked", [{}, {"warehouse": "w"}])
def test_requests_and_answers_are_as_it_says(asked: dict[str, Any]) -> None:
    """An answer has no key that the document does not, nor a request."""
    schemas = openapi(["first-come"])["components"]["schemas"]
    request = asked | {"state": dict(SMALL)}
    assert request.keys() <= schemas["Request"]["properties"].keys()
    answer = json.loads(Service.of(["first-come"]).answer(json.dumps(request).encode()).content)
    jsonschema.validate(answer, schemas["Answer"] | {"additionalProperties": False})
    contents = schemas["State"]["properties"]["pods"]["additionalProperties"]["properties"]["contents"]
    assert contents["additionalProperties"] == {"type": "integer", "nullable": True}
