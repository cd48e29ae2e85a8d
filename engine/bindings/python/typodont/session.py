"""Recorded sessions."""

from __future__ import annotations

import json
import os
import warnings
from pathlib import Path as _File
from typing import Any, Mapping, NamedTuple, Sequence

import numpy as np
from numpy.typing import NDArray

from ._native import Handle, bytes_of, check, ffi, lib, made, struct, text
from .pictures import call, draw, view_of
from .scene import Scene
from .ticks import CUT, TICK, TISSUES, Ticks


class Event(NamedTuple):
    t_s: float
    kind: str
    text: str


class Session(Handle):
    """A recording (.h5), even a truncated one: `with typodont.Session("s.h5") as s: s.ticks["force_z_N"]`."""

    _kind = "session"

    def __init__(self, file: str | os.PathLike[str]) -> None:
        super().__init__(made("session", lib.typodont_session_open, bytes_of(file)))
        self._file = _File(file).resolve()
        info = struct("session_info")
        check(lib.typodont_session_info_of(self._handle, info))
        self.truncated = bool(info.truncated)
        self.rate: float = info.rate
        self.volumes_before_mm3 = {n: info.volumes_before[i] * 1e9 for i, n in enumerate(TISSUES) if i}
        self.volumes_after_mm3 = {n: info.volumes_after[i] * 1e9 for i, n in enumerate(TISSUES) if i}
        self._counts = info.ticks, info.cuts, info.events

    def __len__(self) -> int:
        """Number of ticks."""
        return int(self._counts[0])

    def text(self, what: str) -> str:
        """One text of the session: "scene", "rig", "hand", "trainee", "model", "date" or "version"."""
        place = ffi.new("const char **")
        check(lib.typodont_session_text(self._handle, what.encode(), place))
        return text(place[0])

    @property
    def scene(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.text("scene"))
        return found

    def _rows(self, function: Any, name: str, dtype: Any, first: int, count: int) -> NDArray[Any]:
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
        """Ticks [first, first + count), limited to the existing ticks."""
        return Ticks(self._rows(lib.typodont_session_ticks, "tick", TICK, first,
                                max(0, min(count, self._counts[0] - first))))

    @property
    def cuts(self) -> NDArray[Any]:
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

    def replay(self, program: str = "typodont") -> dict[str, Any]:
        """Replays the session with the program and compares it, as `typodont replay --json`. A session of another force
        law is not replayed: its hand is run again with today's law. A warning then states the difference."""
        found: dict[str, Any] = json.loads(call(program, "replay", self._file, "--json"))
        if not found["same_force_law"]:
            warnings.warn(f"{self._file}: {found['difference']}", stacklevel=2)
        return found

    def render(self, t_s: float, rig: "str | os.PathLike[str] | Mapping[str, Any] | None" = None,
               size: tuple[int, int] = (640, 480), *, towards: Sequence[float] = (0.0, 1.0, -1.0), zoom: float = 1,
               eye: str = "left", view: str = "look", quality: str = "high", program: str = "typodont") -> NDArray[Any]:
        """Draws the session at the time t_s, as Core.render() does."""
        if rig is None:
            with Scene(self.scene, folder=self._file.parent) as scene, scene.core() as core:
                rig = view_of(core.box_mm(), towards, size, zoom)
        return draw(program, self._file, rig, size, eye, "--at", repr(float(t_s)), "--view", view, "--quality", quality)
