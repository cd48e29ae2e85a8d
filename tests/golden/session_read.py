"""Reads a session with h5py, as a user would, and holds it against a CSV of the same ticks.

session_read.py SESSION.h5 [TICKS.csv FORMAT.md]    prints what it found; fails on any difference
"""
import csv
import io
import re
import sys
from contextlib import redirect_stdout

import h5py
import numpy as np


def text(value):
    return value.decode() if isinstance(value, bytes) else value


def labels(dataset):
    return {int(a): b for a, b in (pair.split(" ") for pair in text(dataset.attrs["labels"]).split(", "))}


def bits(*columns):
    """Every bit of some columns of doubles, as one number."""
    total = np.uint64(0)
    with np.errstate(over="ignore"):
        for i, column in enumerate(columns):
            total += np.sum(column[:].view(np.uint64)) * np.uint64(2 * i + 1)
    return int(total)


swmr = len(sys.argv) > 2 and sys.argv[2] == "swmr"
with h5py.File(sys.argv[1], "r", swmr=swmr) as f:
    t = f["ticks"]
    print("format", text(f.attrs["format"]), int(f.attrs["format_version"]), "complete", int(f["complete"][()]))
    print("ticks", len(t["t_s"]), "cuts", len(f["cuts/index"]), "patches", len(f["patches/patch"]))
    print("hand", bits(*(t["hand_" + c] for c in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"))))
    print("force", bits(*(t[f"force_{c}_N"] for c in "xyz")))
    for group in ("ticks", "cuts", "patches"):
        for name, column in f[group].items():
            assert "unit" in column.attrs and text(column.attrs["description"]), name
            assert len(column) == len(f[group][next(iter(f[group]))]), name

    if len(sys.argv) == 4:
        with open(sys.argv[2], newline="") as table:
            rows = list(csv.DictReader(table))
        assert len(rows) == len(t["t_s"])
        tissue = labels(t["tissue"])
        for name in rows[0]:
            if name.startswith("model_force_") or name == "level":
                continue  # of tables only: a replay computes it again
            column = t[name][:]
            for row, value in zip(rows, column):
                same = tissue[int(value)] == row[name] if name == "tissue" else float(value) == float(row[name])
                assert same, (name, row[name], value)
        print("columns", len(rows[0]))

if len(sys.argv) == 4:
    # The example in the documentation runs as printed.
    document = open(sys.argv[3], encoding="utf-8").read()
    example = re.search(r"```python\n(.*?)```", document, re.S).group(1).replace('"session.h5"', repr(sys.argv[1]))
    out = io.StringIO()
    with redirect_stdout(out):
        exec(example, {})
    print("example", out.getvalue().strip())
