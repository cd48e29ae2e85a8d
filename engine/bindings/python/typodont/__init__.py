"""Typodont from Python: scenes, hands, the haptic core, recorded sessions, sound, calibration, sweeps.

>>> scene = typodont.Scene("molar-caries")
>>> ticks = scene.servo("hand.csv")
>>> ticks["force_z_N"].max()

Values with a unit in their name have this unit (mm, N), as in the program's tables. Arrays of structs are in SI units.
"""

import itertools

from . import calibration, sound
from ._native import VERSION as __version__
from ._native import BadInput, Closed, Error, ffi, lib, text
from .case import Case
from .scene import Core, Field, Hand, Mesh, Path, Scene
from .session import Event, Session
from .sound import Synth
from .sweep import rescore, sweep
from .ticks import TISSUES, Ticks

MODELS: tuple[str, ...] = tuple(itertools.takewhile(bool, (text(lib.typodont_model_name(i)) for i in itertools.count())))

__all__ = ["MODELS", "TISSUES", "BadInput", "Case", "Closed", "Core", "Error", "Event", "Field", "Hand", "Mesh", "Path",
           "Scene", "Session", "Synth", "Ticks", "calibration", "rescore", "sound", "sweep", "__version__"]
