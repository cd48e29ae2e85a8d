"""Checks `typodont schema` against the shipped files and the tables of docs/. Usage: schema.py PROGRAM CLAIM"""
import glob
import json
import subprocess
import sys

import jsonschema

FILES = {
    "scene": "scenes/*.json",
    "tool": "tools/*.json implants/bone_level/*.json",
    "motor": "motors/*.json",
    "handpiece": "handpieces/*.json",
    "suction": "suction/*.json",
    "procedure": "implants/procedures/*.json",
    "row": "jaw/*.json",
    "tooth": "teeth/forms/*.json",
    "rig": "rigs/*.json",
    "arm": "devices/*.json",
}
program, claim = sys.argv[1:]


def schema(*arguments):
    return subprocess.run([program, "schema", *arguments], check=True, capture_output=True, text=True).stdout


def misspelt(value):
    """The value with each key misspelt, one at a time, and once in like items of a list."""
    if isinstance(value, list):
        seen = []
        for i, item in enumerate(value):
            if isinstance(item, dict) and list(item) not in seen:
                seen.append(list(item))
                for inner in misspelt(item):
                    yield value[:i] + [inner] + value[i + 1 :]
    elif isinstance(value, dict):
        for key in value:
            yield {name + "s" * (name == key): item for name, item in value.items()}
            for inner in misspelt(value[key]):
                yield {**value, key: inner}


def every_shipped_file_is_valid_and_no_misspelt_key_is():
    for kind, patterns in FILES.items():
        rules = json.loads(schema(kind))
        validator = jsonschema.Draft202012Validator(rules)
        validator.check_schema(rules)
        files = [f for pattern in patterns.split() for f in glob.glob("assets/" + pattern)]
        assert files, kind
        for file in files:
            with open(file) as text:
                document = json.load(text)
            validator.validate(document)
            for wrong in misspelt(document):
                assert not validator.is_valid(wrong), f"{file}: {wrong}"


def the_pages_have_the_tables():
    page = ""
    for name in ("scene_format", "tasks", "interface", "devices"):
        with open(f"docs/{name}.md") as text:
            page += text.read()
    for kind in [*FILES, "paint", "hand"]:
        for table in schema(kind, "--tables").strip().split("\n\n"):
            name, rows = table.split("\n", 1)
            assert rows in page, f"the pages lack the keys of {name}\n{rows}"


{f.__name__: f for f in (every_shipped_file_is_valid_and_no_misspelt_key_is, the_pages_have_the_tables)}[claim]()
