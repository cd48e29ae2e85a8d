"""Scenes, hands, and the haptic core that connects them."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path as _File
from typing import Any, Mapping, NamedTuple, Sequence

import numpy as np
from numpy.typing import NDArray

from ._native import BadInput, Handle, bytes_of, check, dtype, ffi, lib, made, struct, text
from .pictures import draw, view_of, with_files
from .ticks import TICK, TISSUES, Ticks

_VERTEX = dtype("vertex")
_CHUNK = 1 << 16  # ticks that are computed per call


class Path:
    """A hand's path: rows of time and pose. The hand follows it exactly, or as a mass on a spring.

    `t_s`: s, increasing. `p_mm`: n × 3, the centre of the tool's head in W. `q`: unit quaternions w x y z, one or n.
    `pedal`: 0..1, one or n. `mass_kg`: mass of a hand that a spring of `stiffness_N_per_m` pulls along the path and
    that pushes with `push_N`, as in HAND.json. None: the hand follows the path exactly and ignores the force.
    """

    def __init__(self, t_s: Any, p_mm: Any, q: Any = (1, 0, 0, 0), pedal: Any = 1.0, tool: Any = 0,
                 push_N: Any = (0, 0, 0), mass_kg: float | None = None, damping_Ns_per_m: float = 5,
                 stiffness_N_per_m: Any = (0, 0, 0)) -> None:
        t = np.atleast_1d(np.asarray(t_s, float))
        rows = np.zeros(len(t), dtype("hand_row"))
        rows["struct_size"] = rows.dtype.itemsize
        rows["t"] = t
        rows["X_WT"]["p"] = np.asarray(p_mm, float) * 1e-3
        rows["X_WT"]["q"] = q
        rows["pedal"] = pedal
        rows["tool"] = tool
        self.model = None
        if mass_kg is not None:
            self.model = {"mass": mass_kg, "damping": damping_Ns_per_m,
                          "stiffness": np.broadcast_to(np.asarray(stiffness_N_per_m, float), 3).tolist(),
                          "push": [0.0, 0.0, 0.0]}
            rows["push"] = push_N
        self.rows = rows


class Hand(Handle):
    """A hand without a device: a Path, or a file's address (HAND.csv, HAND.json, replay:SESSION.h5)."""

    _kind = "hand"

    def __init__(self, scene: "Scene", hand: "str | os.PathLike[str] | Path", rate: float = 1000) -> None:
        if isinstance(hand, Path):
            model = struct("hand_model", **hand.model) if hand.model else ffi.NULL
            rows = ffi.from_buffer("typodont_hand_row[]", hand.rows)
            super().__init__(made("hand", lib.typodont_hand_path, rows, len(hand.rows), rate, model))
        else:
            super().__init__(made("hand", lib.typodont_hand_open, scene._handle, bytes_of(hand), rate))


class Scene(Handle):
    """A scene: the tissue and the tools.

    `scene`: a file, the name of a shipped scene ("molar-caries"), or a dict of the scene's keys
    (docs/scene_format.md).
    `model`: contact model, replaces the scene's. `folder`: folder of the files that a dict names.
    """

    _kind = "scene"

    def __init__(self, scene: "str | os.PathLike[str] | Mapping[str, Any]", model: str | None = None,
                 folder: str | os.PathLike[str] | None = None) -> None:
        if isinstance(scene, Mapping):
            super().__init__(made("scene", lib.typodont_scene_parse, json.dumps(scene).encode(), bytes_of(folder),
                                  bytes_of(model)))
            self._folder = _File(folder or ".").resolve()
        else:
            super().__init__(made("scene", lib.typodont_scene_open, bytes_of(scene), bytes_of(model)))
            self._folder = _File(scene).resolve().parent

    def _text(self, function: Any, *arguments: Any) -> str | None:
        place = ffi.new("const char **")
        return None if check(function(self._handle, *arguments, place)) == lib.TYPODONT_END else text(place[0])

    @property
    def json(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._text(lib.typodont_scene_text) or "{}")
        return found

    @property
    def model(self) -> str:
        return self._text(lib.typodont_scene_model) or ""

    @property
    def tools(self) -> list[str]:
        names: list[str] = []
        while (name := self._text(lib.typodont_scene_tool, len(names))) is not None:
            names.append(name)
        return names

    def core(self, rate: float = 1000, hand: Hand | None = None) -> "Core":
        """Loads the tissue and returns the haptic core. Call its tick() for each tick, or run() with a hand."""
        options = ffi.NULL if hand else struct("core_options", rate=rate)
        handle = made("core", lib.typodont_core_new, self._handle, hand._handle if hand else ffi.NULL, options)
        return Core(handle, with_files(self.json, self._folder))

    def servo(self, hand: "str | os.PathLike[str] | Path", rate: float = 1000,
              record: str | os.PathLike[str] | None = None, trainee: str | None = None) -> Ticks:
        """Runs the hand to its end, with the same bits as `typodont servo`. `record`: session file (.h5) to write."""
        with Hand(self, hand, rate) as opened, self.core(hand=opened) as core:
            if record is not None:
                core.record(record, trainee)
            ticks = core.run(opened)
            if record is not None:
                core.finish()
            return ticks

    def render(self, *arguments: Any, **options: Any) -> NDArray[Any]:
        """Draws the scene at its start, without a tool, as Core.render() does."""
        with self.core() as core:
            return core.render(*arguments, **options)


class Mesh(NamedTuple):
    """Triangles of one brick."""

    brick: tuple[int, int, int]
    vertices: NDArray[Any]  # structured: position (m), normal, tissue (two ids), second (0..255: fraction of tissue[1])
    triangles: NDArray[Any]  # n × 3 indices of `vertices`; empty: no surface in this brick now


class Field(NamedTuple):
    """A box of voxels: signed distance in m (negative inside) and labels; voxel (0, 0, 0) lies at `origin` (m, W)."""

    distance: NDArray[Any]
    tissue: NDArray[Any]
    origin: NDArray[Any]
    voxel: float


class Core(Handle):
    """The servo and the tissue. Only one thread at a time may use it."""

    _kind = "core"

    def __init__(self, handle: Any, scene: Mapping[str, Any]) -> None:
        super().__init__(handle)
        self._scene = scene
        self._sample = struct("sample")
        self._tick = np.zeros(1, TICK)
        self._tick["struct_size"] = TICK.itemsize
        self._tick_pointer = ffi.from_buffer("typodont_tick *", self._tick)
        self._newest: np.void | None = None

    def tick(self, t_s: float, p_mm: Sequence[float], q: Sequence[float] = (1, 0, 0, 0), pedal: float = 0,
             tool: int = 0) -> np.void:
        """Computes one tick. Returns its struct (SI), valid until the next tick. Invalid poses raise BadInput."""
        sample = self._sample
        sample.t_ns = round(t_s * 1e9)
        sample.X_WT.p = [v * 1e-3 for v in p_mm]
        sample.X_WT.q = [float(v) for v in q]
        sample.pedal, sample.tool = pedal, tool
        check(lib.typodont_core_tick(self._handle, sample, self._tick_pointer, ffi.NULL))
        self._newest = self._tick[0]
        tick: np.void = self._tick[0]
        return tick

    def run(self, hand: Hand) -> Ticks:
        """Computes ticks with the hand's samples until the hand ends."""
        chunks = []
        count = ffi.new("size_t *")
        while True:
            chunk = np.zeros(_CHUNK, TICK)
            chunk["struct_size"][0] = TICK.itemsize
            end = check(lib.typodont_core_run(self._handle, hand._handle, ffi.from_buffer("typodont_tick[]", chunk),
                                              _CHUNK, count)) == lib.TYPODONT_END
            chunks.append(chunk[: count[0]])
            if count[0]:
                self._newest = chunk[count[0] - 1]
            if end:
                return Ticks(chunks[0] if len(chunks) == 1 else np.concatenate(chunks))

    def record(self, file: str | os.PathLike[str], trainee: str | None = None) -> None:
        """Records a session (.h5). Call it before the first tick; finish() creates the file."""
        check(lib.typodont_core_record(self._handle, bytes_of(file), bytes_of(trainee)))

    def finish(self) -> None:
        check(lib.typodont_core_finish(self._handle))

    def _edit(self, function: Any) -> bool:
        done = ffi.new("int32_t *")
        check(function(self._handle, done))
        return bool(done[0])

    def undo(self) -> bool:
        """Reverts the last stroke. False if there is none."""
        return self._edit(lib.typodont_core_undo)

    def redo(self) -> bool:
        return self._edit(lib.typodont_core_redo)

    def mesh(self) -> list[Mesh]:
        """The first call returns all bricks of the surface, each later call the changed bricks."""
        parts, count = ffi.new("const typodont_mesh_part **"), ffi.new("size_t *")
        check(lib.typodont_core_mesh(self._handle, parts, count))

        def copy(pointer: Any, n: int, kind: Any) -> NDArray[Any]:
            if not n:
                return np.empty(0, kind)
            return np.frombuffer(ffi.buffer(pointer, n * kind.itemsize), kind).copy()

        meshes = []
        for i in range(count[0]):
            part = parts[0][i]
            meshes.append(Mesh((part.brick[0], part.brick[1], part.brick[2]), copy(part.vertices, part.vertex_count, _VERTEX),
                               copy(part.indices, part.index_count, np.dtype("u4")).reshape(-1, 3)))
        return meshes

    def _field(self) -> Any:
        field = struct("field")
        check(lib.typodont_core_field(self._handle, field))
        return field

    @property
    def elements(self) -> int:
        """Number of voxels, spheres or vertices of the contact model's tissue."""
        return int(self._field().elements)

    def field(self) -> Field:
        """Copies the whole distance field with its labels."""
        about = self._field()
        low, high = list(about.low), list(about.high)
        size = [max(0, b - a + 1) for a, b in zip(low, high)]
        distance, tissue = np.empty(size, np.float32), np.empty(size, np.uint8)
        if distance.size:
            check(lib.typodont_core_copy(self._handle, low, size, ffi.from_buffer("float[]", distance),
                                         ffi.from_buffer("uint8_t[]", tissue)))
        return Field(distance, tissue, np.array(list(about.origin)) + about.voxel * np.array(low), about.voxel)

    def distance(self, p_mm: Any) -> tuple[NDArray[Any], NDArray[Any]]:
        """Signed distance (mm) and tissue number at n × 3 points (mm, W)."""
        points = np.ascontiguousarray(np.atleast_2d(np.asarray(p_mm, float)) * 1e-3)
        if points.ndim != 2 or points.shape[1] != 3:
            raise BadInput(f"points of shape {np.shape(p_mm)}: expected n × 3")
        distance, tissue = np.empty(len(points)), np.empty(len(points), np.uint8)
        check(lib.typodont_core_query(self._handle, ffi.from_buffer("double[]", points), len(points),
                                      ffi.from_buffer("double[]", distance), ffi.from_buffer("uint8_t[]", tissue)))
        return distance * 1e3, tissue

    @property
    def volumes_mm3(self) -> dict[str, float]:
        volumes = ffi.new("double[]", lib.TYPODONT_TISSUES)
        check(lib.typodont_core_volumes(self._handle, volumes))
        return {name: volumes[i] * 1e9 for i, name in enumerate(TISSUES) if i}

    @property
    def hash(self) -> str:
        """Hash of all tissue, equal to field_hash of `typodont servo --json`."""
        value = ffi.new("uint64_t *")
        check(lib.typodont_core_hash(self._handle, value))
        return f"{value[0]:016x}"

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes the tissue as a volume (.vdb)."""
        check(lib.typodont_core_save(self._handle, bytes_of(_File(file))))

    def box_mm(self) -> tuple[NDArray[Any], NDArray[Any]]:
        """The lowest and highest corner of a box around the tissue, mm, W."""
        about = self._field()
        origin, voxel = np.array(list(about.origin)), about.voxel
        low, high = ((origin + voxel * np.array(list(corner))) * 1e3 for corner in (about.low, about.high))
        return low, high

    def render(self, rig: "str | os.PathLike[str] | Mapping[str, Any] | None" = None, size: tuple[int, int] = (640, 480),
               *, towards: Sequence[float] = (0.0, 1.0, -1.0), zoom: float = 1, eye: str = "left", view: str = "look",
               quality: str = "high", program: str = "typodont") -> NDArray[Any]:
        """Draws the present tissue, and the tool at the proxy's pose in the newest tick: height × width × 3, uint8.

        `rig`: a rig file, the name of a shipped one ("closeup"), or a dict of its keys; None: shows all of the tissue,
        seen along `towards` (W), `zoom` times larger. `eye`: "left", "right", or "both" for a pair of pictures.
        `view`: "look", "section" or "xray". The program `typodont` draws it, which takes about a second.
        """
        if rig is None:
            rig = view_of(self.box_mm(), towards, size, zoom)
        with tempfile.TemporaryDirectory() as name:
            folder = _File(name)
            (folder / "scene.json").write_text(json.dumps(self._scene))
            self.save(folder / "tissue.vdb")
            words: list[Any] = ["--volume", folder / "tissue.vdb", "--view", view, "--quality", quality]
            if self._newest is not None:
                held = self._newest["X_WG"]
                row = [0, *(held["p"] * 1e3), *held["q"], self._newest["pedal"], self._newest["tool"]]
                (folder / "hand.csv").write_text("t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal,tool\n" +
                                                 ",".join(map(repr, map(float, row[:-1]))) + f",{row[-1]}\n")
                words += ["--pose", folder / "hand.csv"]
            return draw(program, folder / "scene.json", rig, size, eye, *words)
