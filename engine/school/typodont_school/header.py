"""Prints the header of a session file as JSON, and the hash of its first forces; run as a child process with limits."""
import hashlib
import json
import sys

import h5py
import numpy as np

FORCES = ("ticks/force_x_N", "ticks/force_y_N", "ticks/force_z_N")
FIRST, FEWEST = 500, 100  # ticks in contact


def text(value, most):
    value = value.decode() if isinstance(value, bytes) else str(value)
    return value[:most]


def first_forces(f):
    """Returns the hash of the first forces in contact, which a shortened copy keeps; empty if there are too few."""
    touching = np.flatnonzero(f["ticks/contact_area_mm2"][:])[:FIRST]
    if len(touching) < FEWEST:
        return ""
    rows = slice(touching[0], touching[-1] + 1)
    return hashlib.sha256(b"".join(f[name][rows].tobytes() for name in FORCES)).hexdigest()[:16]


with h5py.File(sys.argv[1], "r") as f:
    json.dump({"first_forces": first_forces(f), "scene": json.loads(text(f["header/scene"][()], 1 << 24)), "files": json.loads(text(f["header/files"][()], 1 << 20)),
               "trainee": text(f.attrs.get("trainee", ""), 40), "date": text(f.attrs.get("date", ""), 40)}, sys.stdout)
