"""The servo's ticks as columns."""

from __future__ import annotations

import os
from typing import Any, Iterator

import numpy as np
from numpy.typing import NDArray

from ._native import dtype, ffi, lib, text

TISSUES: tuple[str, ...] = tuple(text(lib.typodont_tissue_name(i)) for i in range(lib.TYPODONT_TISSUES)
                                 if lib.typodont_tissue_name(i) != ffi.NULL)
TICK = dtype("tick")
CUT = dtype("cut")

_KRPM = 2 * np.pi * 1000.0 / 60.0  # rad/s


def _columns() -> dict[str, tuple[tuple[Any, ...], float]]:
    """Maps a column's name in tables (docs/interface.md, "Ticks") to its field in the struct and its factor on SI."""
    columns: dict[str, tuple[tuple[Any, ...], float]] = {}

    def vector(name: str, unit: str, path: tuple[Any, ...], factor: float) -> None:
        for i, axis in enumerate("xyz"):
            columns[f"{name}_{axis}{unit}"] = (path + (i,), factor)

    vector("hand", "_mm", ("X_WT", "p"), 1e3)
    vector("tool", "_mm", ("X_WG", "p"), 1e3)
    vector("force", "_N", ("force",), 1)
    vector("torque", "_Nmm", ("torque",), 1e3)
    columns["depth_mm"] = (("depth",), 1e3)
    vector("normal", "", ("normal",), 1)
    columns["contact_area_mm2"] = (("contact_area",), 1e6)
    for i, tissue in enumerate(TISSUES):
        if i:
            columns[f"removed_{tissue}_mm3"] = (("removed", i), 1e9)
    columns["tissue"] = (("tissue",), 1)
    columns["energy_mJ"] = (("energy",), 1e3)
    columns["faults"] = (("faults",), 1)
    columns["pedal"] = (("pedal",), 1)
    columns["tool"] = (("tool",), 1)
    vector("model_force", "_N", ("model_force",), 1)
    columns["level"] = (("level",), 1)
    columns["wear"] = (("wear",), 1)
    return columns


_COLUMNS = _columns()


class Ticks:
    """Ticks of a run or of a recorded session.

    `array` is a NumPy array of the library's structs, in SI, without a copy. `ticks["force_z_N"]` is a column by its
    name in the tables. A column in SI units is a view of `array`, a column in other units a new array. `frame()`
    returns all columns as a pandas DataFrame.
    """

    def __init__(self, array: NDArray[Any]) -> None:
        self.array = array

    def __len__(self) -> int:
        return len(self.array)

    @property
    def columns(self) -> list[str]:
        return ["t_s", *_COLUMNS, "removed_mm3", "spindle_krpm"]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name == "t_s":
            return self.array["t_ns"] / 1e9
        if name == "removed_mm3":
            removed = self.array["removed"]  # summed in the program's order: equal bits
            return np.asarray(sum(removed[:, i] for i in range(len(TISSUES)))) * 1e9
        if name == "spindle_krpm":
            return self.array["spindle"] / _KRPM
        if name not in _COLUMNS:
            raise KeyError(f"{name!r}: expected one of {', '.join(self.columns)}")
        path, factor = _COLUMNS[name]
        column: Any = self.array
        for step in path:
            column = column[:, step] if isinstance(step, int) else column[step]
        found: NDArray[Any] = column if factor == 1 else column * factor
        return found

    @property
    def force(self) -> NDArray[Any]:
        """N, force on the hand, n × 3; a view of `array`."""
        force: NDArray[Any] = self.array["force"]
        return force

    def frame(self) -> Any:
        """A pandas DataFrame with the columns of the tables."""
        import pandas

        return pandas.DataFrame({name: np.ascontiguousarray(self[name]) for name in self.columns})

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes the array as .npy. `Ticks.load` reads it."""
        np.save(file, self.array)

    @staticmethod
    def load(file: str | os.PathLike[str]) -> "Ticks":
        array = np.load(file)
        if array.dtype != TICK:
            raise ValueError(f"{file}: found {array.dtype.itemsize} bytes a row, expected ticks of this version")
        return Ticks(array)
