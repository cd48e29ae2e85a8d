#!/usr/bin/env python3
"""Lists names that anonymous namespaces of two files of one CMake target share. A unity build may compile these files
together, and then refuses them. Usage: unity_names.py BUILD_FOLDER; fails if there are any."""
import collections
import pathlib
import re
import sys


def names_in(file):
    """Constants, types and functions (with their parameters) of the file's anonymous namespaces."""
    inside = False
    for line in file.read_text().splitlines():
        if re.match(r"namespace\b.*\{$|\}  // namespace", line):
            inside = line == "namespace {"
        if not inside or not re.match(r"[a-zA-Z]", line) or line.startswith("namespace "):
            continue
        line = line.split("//")[0]
        if kind := re.match(r"(?:class|struct|enum(?: class)?) (\w+)(?: final)?(?: [:{]|;)", line):
            yield kind[1]
        elif re.match(r"(?:static |inline )?(?:const |constexpr )", line) and not re.search(r"\) (?:noexcept )?\{$", line):
            yield from re.findall(r"(\w+)(?:\[[^\]]*\])*(?: =|\{)", line)
        elif function := re.search(r"[\w>*&] [*&]?(\w+\(.*\)) (?:const )?(?:noexcept )?\{", line):
            yield function[1]


targets = collections.defaultdict(set)
for unit in pathlib.Path(sys.argv[1]).rglob("Unity/unity_*.cxx"):
    targets[unit.parent.parent.stem].update(re.findall(r'#include "(.*)"', unit.read_text()))
if not targets:
    sys.exit("no unity build in " + sys.argv[1])
shared = []
for target, files in sorted(targets.items()):
    owners = collections.defaultdict(set)
    for file in map(pathlib.Path, files):
        for name in names_in(file):
            owners[name].add(file.name)
    shared += [f"{target}: {name}: {', '.join(sorted(of))}" for name, of in sorted(owners.items()) if len(of) > 1]
print(*shared, sep="\n")
sys.exit(1 if shared else 0)
