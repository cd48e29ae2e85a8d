#!/usr/bin/env python3
"""Writes costs.txt anew from the log of a complete run of all tests.

Usage: renew_costs.py build/release/Testing/Temporary/LastTest.log
A test that took at least LEAST ms gets a line. If the other tests of its suite took as long together, the suite gets a
line, too.
"""
import collections
import pathlib
import re
import sys

LEAST = 2000  # ms

kind = None
took = collections.defaultdict(dict)  # took[KIND.Suite][Claim]: ms
for line in pathlib.Path(sys.argv[1]).read_text(errors="replace").splitlines():
    if found := re.match(r"\d+/\d+ Test: (\w+)\.", line):
        kind = found[1]
    elif found := re.match(r"\[       OK \] ([\w/]+)\.([\w/]+)(?:, where .*)? \((\d+) ms\)$", line):
        took[f"{kind}.{found[1]}"][found[2]] = int(found[3])
costs = {}
for suite, tests in took.items():
    expensive = {test: ms for test, ms in tests.items() if ms >= LEAST}
    others = sum(tests.values()) - sum(expensive.values())
    costs |= {f"{suite}.{test}": ms for test, ms in expensive.items()}
    if others >= LEAST:
        costs[suite] = others
lines = [f"{ms} {name}\n" for name, ms in sorted(costs.items(), key=lambda item: (-item[1], item[0]))]
header = f"# Tests that take {LEAST} ms or longer: time in ms, name. Written by renew_costs.py. Read by add_tests.cmake.\n"
(pathlib.Path(__file__).parent / "costs.txt").write_text(header + "".join(lines))
