"""Documents against their published schemas."""

import json
from functools import cache

from jsonschema import Draft202012Validator

from facezip.documents.published import published


@cache
def _validator(name):
    """Of a schema that allows no field besides those that it names: a program of this version says nothing else."""
    schema = json.loads(published(name))
    for part in schema["$defs"].values():
        part["additionalProperties"] = False
    return Draft202012Validator(schema)


def check(document):
    """Raise for a document that its schema does not describe; returns its name."""
    name = document["format"].removeprefix("facezip-").partition("/")[0]
    faults = [f"{fault.json_path}: {fault.message[:300]}" for fault in _validator(name).iter_errors(document)]
    assert not faults, (name, faults[:5])
    return name


def checked(arguments, stdout):
    """The output of a command line, whose JSON is as published."""
    if "--json" in arguments and stdout.lstrip().startswith("{"):
        check(json.loads(stdout))
    return stdout
