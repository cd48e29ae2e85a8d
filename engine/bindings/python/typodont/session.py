"""Recorded sessions."""

from __future__ import annotations

import json
import os
from typing import Any, NamedTuple

import numpy as np

from ._native import Handle, bytes_of, check, ffi, lib, made, struct, text
from .ticks import CUT, TICK, TISSUES, Ticks


class Event(NamedTuple):
    t_s: float
    kind: str
    text: str


class Session(Handle):
    """A recording (.h5), also one that was cut off: `with typodont.Session("s.h5") as s: s.ticks["force_z_N"]`."""

    _kind = "session"

    def __init__(self, file: str | os.PathLike[str]) -> None:
        super().__init__(made("session", lib.typodont_session_open, bytes_of(file)))
        info = struct("session_info")
        check(lib.typodont_session_info_of(self._handle, info))
        self.truncated = bool(info.truncated)
        self.rate: float = info.rate
        self.volumes_before_mm3 = {n: info.volumes_before[i] * 1e9 for i, n in enumerate(TISSUES) if i}
        self.volumes_after_mm3 = {n: info.volumes_after[i] * 1e9 for i, n in enumerate(TISSUES) if i}
        self._counts = info.ticks, info.cuts, info.events

    def __len__(self) -> int:
        """Ticks."""
        return self._counts[0]

    def text(self, what: str) -> str:
        """Of "scene", "rig", "hand", "trainee", "model", "date", "version"."""
        place = ffi.new("const char **")
        check(lib.typodont_session_text(self._handle, what.encode(), place))
        return text(place[0])

    @property
    def scene(self) -> dict[str, Any]:
        return json.loads(self.text("scene"))

    def _rows(self, function: Any, name: str, dtype: Any, first: int, count: int) -> np.ndarray:
        rows = np.zeros(count, dtype)
        if not count:
            return rows
        rows["struct_size"][0] = dtype.itemsize
        read = ffi.new("size_t *")
        check(function(self._handle, first, ffi.from_buffer(f"typodont_{name}[]", rows), count, read))
        return rows[: read[0]]

    @property
    def ticks(self) -> Ticks:
        return self.ticks_from(0, self._counts[0])

    def ticks_from(self, first: int, count: int) -> Ticks:
        """Ticks [first, first + count), as far as there are any."""
        return Ticks(self._rows(lib.typodont_session_ticks, "tick", TICK, first,
                                max(0, min(count, self._counts[0] - first))))

    @property
    def cuts(self) -> np.ndarray:
        """All cuts, in SI: index, tick, X_WA, X_WB, removed …"""
        return self._rows(lib.typodont_session_cuts, "cut", CUT, 0, self._counts[1])

    @property
    def events(self) -> list[Event]:
        events = []
        event = struct("event")
        for i in range(self._counts[2]):
            check(lib.typodont_session_event(self._handle, i, event))
            events.append(Event(event.t_ns * 1e-9, text(event.kind), text(event.text)))
        return events

    def frame(self) -> Any:
        """The ticks as a pandas DataFrame."""
        return self.ticks.frame()
