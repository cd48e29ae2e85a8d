"""Pictures as arrays. The program `typodont` draws them without a window; without a GPU, the CPU draws."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import zlib
from pathlib import Path as _File
from typing import Any, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ._native import BadInput, Error

_DISTANCE = 400.0  # mm, distance from the eyes to the middle of the picture


def call(program: str, *words: Any) -> str:
    """Runs `typodont` with these arguments and returns its output. Raises the exception for its exit status."""
    try:
        done = subprocess.run([program, *map(os.fspath, words)], capture_output=True, text=True)
    except FileNotFoundError as error:
        raise Error(f"no program {program!r}: install the Debian package, or name it with program=") from error
    if done.returncode:
        why = done.stderr.strip() or f"{program}: exit status {done.returncode}"
        raise BadInput(why) if done.returncode == 2 else Error(why)
    return done.stdout


def view_of(box_mm: tuple[NDArray[Any], NDArray[Any]], towards: Sequence[float], size: tuple[int, int],
            zoom: float = 1) -> dict[str, Any]:
    """Returns a rig whose picture shows a whole box (corners in W): the screen contains the box's middle."""
    low, high = box_mm
    away = np.asarray(towards, float)
    if not (np.linalg.norm(away) > 0 and zoom > 0 and min(size) > 0):
        raise BadInput(f"towards {tuple(towards)}, zoom {zoom}, size {tuple(size)}: expected a direction and numbers above 0")
    away = away / np.linalg.norm(away)
    right = np.cross(away, (0, 0, 1))
    if np.linalg.norm(right) < 1e-6:  # the view is from above or from below
        right = np.array([1.0, 0, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, away)
    across, upright = (np.abs(axis) @ (high - low) for axis in (right, up))  # mm, extent of the box in the view
    height = 1.05 * max(upright, across * size[1] / size[0]) / zoom
    half_up, half_right = up * height / 2, right * height / 2 * size[0] / size[1]
    middle = (low + high) / 2
    return {
        "display": "offscreen",
        "screen": {
            "corners_mm": {"lower_left": (middle - half_right - half_up).tolist(),
                           "lower_right": (middle + half_right - half_up).tolist(),
                           "upper_left": (middle - half_right + half_up).tolist()},
            "pixels": [2 * size[0], size[1]],
            "layout": "side_by_side",
        },
        "head": {"eye_center_mm": (middle - _DISTANCE * away).tolist(), "ipd_mm": 63, "right": right.tolist()},
    }


def draw(program: str, source: str | os.PathLike[str], rig: Any, size: tuple[int, int], eye: str,
         *words: Any) -> NDArray[Any]:
    """Draws the picture of one eye (height × width × 3 bytes) or of both eyes (2 × height × width × 3)."""
    eyes = {"left": ["left"], "right": ["right"], "both": ["left", "right"]}.get(eye)
    if eyes is None:
        raise BadInput(f"eye: {eye!r}, expected left, right or both")
    with tempfile.TemporaryDirectory() as name:
        folder = _File(name)
        if isinstance(rig, Mapping):
            (folder / "rig.json").write_text(json.dumps(rig))
            rig = folder / "rig.json"
        call(program, "render", source, "--rig", rig, "--size", f"{size[0]}x{size[1]}", "--eye", eye, "--out", folder,
             *words)
        pictures = [_read_png(folder / f"{one}.png") for one in eyes]
    return np.stack(pictures) if eye == "both" else pictures[0]


def with_files(value: Any, folder: _File) -> Any:
    """Returns the scene with absolute file names, so that it can be read from another folder."""
    if isinstance(value, Mapping):
        return {key: with_files(v, folder) for key, v in value.items()}
    if isinstance(value, list):
        return [with_files(v, folder) for v in value]
    if isinstance(value, str) and _File(value).suffix and (folder / value).is_file():
        return str((folder / value).resolve())
    return value


def _read_png(file: _File) -> NDArray[Any]:
    """Reads a PNG of the program: 8-bit RGB with unfiltered rows."""
    data = file.read_bytes()
    at, packed = 8, b""
    shape = (0, 0)
    while at < len(data):
        size, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        content = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            shape = (int.from_bytes(content[4:8], "big"), int.from_bytes(content[:4], "big"))
            if content[8:13] != bytes([8, 2, 0, 0, 0]):
                raise Error(f"{file}: expected 8-bit RGB")
        elif kind == b"IDAT":
            packed += content
        at += size + 12
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(shape[0], 1 + 3 * shape[1])
    if rows[:, 0].any():
        raise Error(f"{file}: expected rows without filters")
    return rows[:, 1:].reshape(*shape, 3).copy()
