"""Calibration from arrays: registration of the haptic base and the display, and the delay between two recordings."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._native import check, ffi, lib, struct, text


class Registration(NamedTuple):
    """The rigid motion p_D = X_DH · p_H. Millimetres."""

    matrix: NDArray[Any]  # 4 × 4
    fre_rms_mm: float
    sigma_mm: float
    predicted_tre_mm: float
    covariance: NDArray[Any]  # 6 × 6 of (rotation vector in rad, translation in m)
    inliers: NDArray[Any]  # bool, for each pair: True if it was used
    trusted: bool
    why_not: str


def _points(p_mm: Any) -> NDArray[Any]:
    return np.ascontiguousarray(np.asarray(p_mm, float).reshape(-1, 3) * 1e-3)


def register(h_mm: Any, d_mm: Any, sigma_mm: float = 0) -> Registration:
    """Fits the motion to pairs of points: touched in the haptic base H, seen in the display D; n × 3 each."""
    h, d = _points(h_mm), _points(d_mm)
    if len(h) != len(d):
        raise ValueError(f"{len(h)} and {len(d)} points: expected pairs")
    out, inliers = struct("registration"), np.zeros(len(h), np.uint8)
    check(lib.typodont_register(ffi.from_buffer("double[]", h), ffi.from_buffer("double[]", d), len(h),
                                sigma_mm * 1e-3, out, ffi.from_buffer("uint8_t[]", inliers)))
    w, x, y, z = out.X_DH.q
    matrix = np.eye(4)
    matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                      [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    matrix[:3, 3] = np.array(list(out.X_DH.p)) * 1e3
    trusted = bool(out.trusted)
    return Registration(matrix, out.fre_rms * 1e3, out.sigma * 1e3, out.predicted_tre * 1e3,
                        np.array(list(out.covariance)).reshape(6, 6), inliers.astype(bool), trusted,
                        "" if trusted else text(lib.typodont_error()))


class Delay(NamedTuple):
    delay_ms: float  # positive: B lags A
    sigma_ms: float
    ambiguous: bool


def delay(t_a: Any, a_mm: Any, t_b: Any, b_mm: Any, max_ms: float = 2000) -> Delay:
    """Estimates the delay between two recordings of one motion: times in s, n × 3 points."""
    ta, tb = (np.ascontiguousarray(np.asarray(t, float)) for t in (t_a, t_b))
    a, b = _points(a_mm), _points(b_mm)
    if len(ta) != len(a) or len(tb) != len(b):
        raise ValueError("times and points: expected as many of both")
    out = struct("delay")
    check(lib.typodont_estimate_delay(ffi.from_buffer("double[]", ta), ffi.from_buffer("double[]", a), len(ta),
                                      ffi.from_buffer("double[]", tb), ffi.from_buffer("double[]", b), len(tb),
                                      max_ms * 1e-3, out))
    return Delay(out.delay * 1e3, out.sigma * 1e3, bool(out.ambiguous))
