"""Prints the header of a session file as JSON; run as a child process with limits."""
import json
import sys

import h5py


def text(value, most):
    value = value.decode() if isinstance(value, bytes) else str(value)
    return value[:most]


with h5py.File(sys.argv[1], "r") as f:
    json.dump({"scene": json.loads(text(f["header/scene"][()], 1 << 24)), "files": json.loads(text(f["header/files"][()], 1 << 20)),
               "trainee": text(f.attrs.get("trainee", ""), 40), "date": text(f.attrs.get("date", ""), 40)}, sys.stdout)
