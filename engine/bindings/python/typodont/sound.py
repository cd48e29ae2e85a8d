"""The drill's sound: fits models to recordings, and synthesizes samples from ticks."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._native import Handle, bytes_of, check, ffi, lib, made, struct
from .ticks import Ticks


class Synth(Handle):
    """A synthesizer with a voice: a file, or the name of a shipped voice ("micromotor")."""

    _kind = "synth"

    def __init__(self, voice: str | os.PathLike[str], sample_rate: float = 48000, seed: int = 1) -> None:
        super().__init__(made("synth", lib.typodont_synth_new, bytes_of(voice), sample_rate, seed))
        self.sample_rate = sample_rate

    def push(self, t_s: float, **state: float) -> None:
        """Sets the state from t_s on: spindle (rad/s), pedal, force (N), contact_area (m²), removal_rate (m³/s), …"""
        known: dict[str, float] = {"turns": 1, **state}
        for name in ("turns", "tissue"):
            known[name] = int(known.get(name, 0))
        check(lib.typodont_synth_push(self._handle, struct("sound_state", t_ns=round(t_s * 1e9), **known)))

    def render(self, count: int) -> NDArray[Any]:
        """Computes the next `count` samples, with full scale 1."""
        samples = np.empty(count, np.float32)
        check(lib.typodont_synth_render(self._handle, ffi.from_buffer("float[]", samples), count))
        return samples

    def voice(self, ticks: Ticks) -> NDArray[Any]:
        """Computes the sound of a whole run."""
        a = ticks.array
        t = a["t_ns"] * 1e-9
        removed = a["removed"].sum(axis=1)
        rate = np.gradient(removed, t) if len(a) > 1 else np.zeros(len(a))
        force = np.linalg.norm(a["force"], axis=1)
        parts, done = [], 0
        for i in range(len(a)):
            self.push(t[i], spindle=a["spindle"][i], pedal=a["pedal"][i], contact_area=a["contact_area"][i],
                      force=force[i], removal_rate=max(0.0, rate[i]), tissue=a["tissue"][i])
            if i % 1000 == 999 or i == len(a) - 1:
                until = round(t[i] * self.sample_rate)
                parts.append(self.render(until - done))
                done = until
        return np.concatenate(parts) if parts else np.empty(0, np.float32)


def fit(recording: str | os.PathLike[str], model: str | os.PathLike[str], order: int | str = 300) -> float:
    """Fits an autoregressive model to a recording and writes it. Returns the log-spectral distance, dB."""
    distance = ffi.new("double *")
    check(lib.typodont_sound_fit(bytes_of(recording), str(order).encode(), bytes_of(model), distance))
    return float(distance[0])
