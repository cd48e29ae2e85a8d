"""Exercises from a family, a seed and a difficulty. The program `typodont` makes them."""

from __future__ import annotations

import json
import os
from pathlib import Path as _File

from .pictures import call
from .scene import Scene


class Case:
    """Makes an exercise: the scene `out`, and its volume beside it. Equal arguments give equal files.

    `tooth`: a tooth of the family, for example "L6"; without it, the seed selects one. `program`: found in the PATH.
    """

    def __init__(self, family: str, seed: int = 1, difficulty: float = 0.5, *, out: str | os.PathLike[str],
                 tooth: str | None = None, program: str = "typodont") -> None:
        words = ["case", family, "--seed", str(seed), "--difficulty", str(difficulty), "--out", os.fspath(out), "--json"]
        made = json.loads(call(program, *words, *(["--tooth", tooth] if tooth else [])))
        self.file = _File(out)
        self.family: str = family
        self.seed, self.difficulty = seed, difficulty
        self.tooth: str = made["tooth"]
        self.parameters: dict[str, float] = made["parameters"]  # mm, degrees or years
        self.expert_points: float = made["expert_points"]
        self.careless_points: float = made["careless_points"]

    def scene(self) -> Scene:
        return Scene(self.file)
