"""Runs every scene with every hand and every set of parameters, on this machine's cores or on a Dask cluster.

The result of each run is written to a file in the sweep's folder at once. Call an interrupted sweep again with the
same folder to continue it. A run whose worker died is repeated.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import multiprocessing
import os
import tempfile
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path as _File
from typing import Any, Callable, Iterable, Iterator, Mapping, NamedTuple

import numpy as np

from ._native import VERSION
from .pictures import call, with_files
from .scene import Hand, Path, Scene

Row = dict[str, Any]
_TRIES = 4  # maximum number of tries of a run whose worker dies; after them, the run counts as the cause


class Job(NamedTuple):
    """The description of one run for a worker."""

    key: str  # hash of everything that determines the result
    labels: Row  # columns of the table that identify the run
    call: Callable[..., Row]
    arguments: tuple[Any, ...]


def _run(scene: Mapping[str, Any], folder: str, hand: Any, rate: float,
         measure: Callable[[Any, Any], Row] | None) -> Row:
    with Scene(scene, folder=folder) as opened, Hand(opened, hand, rate) as moves, opened.core(hand=moves) as core:
        volumes = core.volumes_mm3
        ticks = core.run(moves)
        array = ticks.array
        row: Row = {
            "ticks": len(array),
            "cuts": int(array["cuts"][-1]) if len(array) else 0,
            "removed_mm3": float(ticks["removed_mm3"][-1]) if len(array) else 0.0,
            **{f"removed_{name}_mm3": float(ticks[f"removed_{name}_mm3"][-1]) if len(array) else 0.0
               for name, before in volumes.items() if before > 0},
            "force_max_N": float(np.sqrt((array["force"] ** 2).sum(axis=1).max())) if len(array) else 0.0,
            "energy_min_J": float(min(0.0, array["energy"].min())) if len(array) else 0.0,
            "faults": int(np.bitwise_or.reduce(array["faults"])) if len(array) else 0,
            "tick_us_median": float(np.median(array["cpu_ns"]) * 1e-3) if len(array) else 0.0,
            "field_hash": core.hash,
        }
        if measure:
            row.update(measure(ticks, core))
        return row


def _named(things: Any) -> dict[str, Any]:
    if isinstance(things, Mapping) and not ("tissue" in things):
        return dict(things)
    if isinstance(things, (str, os.PathLike, Path)) or isinstance(things, Mapping):
        things = [things]
    names: dict[str, Any] = {}
    for i, thing in enumerate(things):
        name = _File(thing).stem if isinstance(thing, (str, os.PathLike)) else \
            str(thing.get("name", i)) if isinstance(thing, Mapping) else str(i)
        names[name if name not in names else f"{name}#{i}"] = thing
    return names


def _sets(parameters: Any) -> Iterator[Row]:
    """{"model": ["offset", "packing"], "friction": [True, False]} gives all pairs; a list of dicts stays unchanged."""
    if parameters is None:
        yield {}
    elif isinstance(parameters, Mapping):
        for values in itertools.product(*parameters.values()):
            yield dict(zip(parameters, values))
    else:
        yield from parameters


def _label(value: Any) -> Any:
    return value if isinstance(value, (str, int, float, bool)) or value is None else json.dumps(value, sort_keys=True)


def _content(hand: Any) -> bytes:
    """The hand's content that determines the result."""
    if isinstance(hand, Path):
        return bytes(hand.rows.tobytes()) + json.dumps(hand.model).encode()
    file = _File(os.fspath(hand).removeprefix("script:").removeprefix("replay:"))
    if not file.is_file():
        return str(hand).encode()
    content = file.read_bytes()
    if file.suffix == ".json":
        content += (file.parent / json.loads(content)["path"]).read_bytes()
    kind, colon, _ = str(hand).partition(":")
    return (kind.encode() if colon else b"") + content


def _digest(scene: Any, known: dict[str, str]) -> list[str]:
    """Digests of the files that a scene names by absolute path. `known`: digests of files that were read before."""
    if isinstance(scene, Mapping):
        scene = list(scene.values())
    if isinstance(scene, list):
        return [digest for value in scene for digest in _digest(value, known)]
    if not isinstance(scene, str) or not os.path.isabs(scene) or not os.path.isfile(scene):
        return []
    if scene not in known:
        digest = hashlib.sha256()
        with open(scene, "rb") as file:
            for chunk in iter(lambda: file.read(1 << 20), b""):
                digest.update(chunk)
        known[scene] = digest.hexdigest()
    return [known[scene]]


def _jobs(scenes: Any, hands: Any, parameters: Any, rate: float,
          measure: Callable[[Any, Any], Row] | None) -> list[Job]:
    jobs = []
    digests: dict[str, str] = {}
    for scene_name, scene in _named(scenes).items():
        with Scene(scene) as opened:
            base = opened.json
        file = _File(scene).resolve() if isinstance(scene, (str, os.PathLike)) and _File(scene).exists() else None
        folder = str(file.parent if file else _File.cwd())
        for hand_name, hand in _named(hands).items():
            content = _content(hand)
            for values in _sets(parameters):
                whole = with_files({**base, **values}, _File(folder))
                name = f"{measure.__module__}.{measure.__qualname__}" if measure else ""
                text = json.dumps([whole, _digest(whole, digests), rate, VERSION, name], sort_keys=True)
                key = hashlib.sha256(text.encode() + content).hexdigest()[:32]
                labels = {"scene": scene_name, "hand": hand_name, **{k: _label(v) for k, v in values.items()}}
                travels = hand if isinstance(hand, Path) else os.fspath(hand)
                if isinstance(travels, str) and _File(travels).exists():
                    travels = str(_File(travels).resolve())
                jobs.append(Job(key, labels, _run, (whole, folder, travels, rate, measure)))
    return jobs


def _do(job: Job) -> tuple[str, Row]:
    """Runs one job in a worker. A failure of the run itself becomes a row with an error and is not repeated."""
    try:
        return job.key, job.call(*job.arguments)
    except Exception as error:
        return job.key, {"error": f"{type(error).__name__}: {error}"}


def _in_processes(jobs: list[Job], workers: int) -> Iterator[tuple[str, Row]]:
    """A pool breaks if one of its processes dies. A new pool then takes the remaining runs. A run that was active in
    several broken pools gets a process of its own, so that it can end only this process."""
    tries = dict.fromkeys((job.key for job in jobs), 0)
    left = {job.key: job for job in jobs}
    context = multiprocessing.get_context("spawn")
    while left:
        suspects = [job for job in left.values() if tries[job.key] >= 2]
        batch, size = (suspects[:1], 1) if suspects else (list(left.values()), workers)
        with ProcessPoolExecutor(min(size, len(batch)), mp_context=context) as pool:
            waiting = iter(batch)
            running: dict[Future[tuple[str, Row]], Job] = {}
            try:
                # Submit only as many runs as there are workers, so that a broken pool affects few runs.
                for job in itertools.islice(waiting, size):
                    running[pool.submit(_do, job)] = job
                while running:
                    done, _ = wait(running, return_when=FIRST_COMPLETED)
                    for future in done:
                        key, row = future.result()
                        del running[future]
                        del left[key]
                        yield key, row
                        for job in itertools.islice(waiting, 1):
                            running[pool.submit(_do, job)] = job
            except BrokenProcessPool:
                for job in running.values():
                    tries[job.key] += 1
                    if job.key in left and tries[job.key] >= _TRIES:
                        del left[job.key]
                        yield job.key, {"error": f"its process died {_TRIES} times"}


def _on_cluster(jobs: list[Job], scheduler: Any) -> Iterator[tuple[str, Row]]:
    """Runs on Dask. `scheduler` is an address or a Client. The scheduler itself repeats the runs of a dead worker."""
    from distributed import Client, as_completed

    client: Any = scheduler if isinstance(scheduler, Client) else Client(scheduler)  # type: ignore[no-untyped-call]
    try:
        futures = client.map(_do, jobs, pure=False, retries=_TRIES, key=[f"typodont-{job.key}" for job in jobs])
        keys = {future.key: job.key for future, job in zip(futures, jobs)}
        for future in as_completed(futures):  # type: ignore[no-untyped-call]
            if future.status == "finished":
                yield future.result()
            else:
                yield keys[future.key], {"error": f"{type(future.exception()).__name__}: {future.exception()}"}
    finally:
        if client is not scheduler:
            client.close()


def _table(rows: list[Row]) -> Any:
    """A pandas DataFrame if pandas is installed, otherwise the rows."""
    try:
        import pandas
    except ImportError:
        return rows
    return pandas.DataFrame(rows)


def _keep(file: _File, row: Row) -> None:
    """Writes the row's file completely or not at all."""
    with tempfile.NamedTemporaryFile("w", dir=file.parent, delete=False, suffix=".part") as part:
        json.dump(row, part)
    os.replace(part.name, file)


def _carry_out(jobs: list[Job], folder: str | os.PathLike[str] | None, scheduler: Any, workers: int | None,
               progress: Callable[[int, int], None] | None) -> Any:
    results: dict[str, Row] = {}
    place = _File(folder) if folder is not None else None
    if place:
        place.mkdir(parents=True, exist_ok=True)
        for job in jobs:
            file = place / f"{job.key}.json"
            if file.exists():
                results[job.key] = json.loads(file.read_text())
    left = list({job.key: job for job in jobs if job.key not in results}.values())
    cores = workers or len(os.sched_getaffinity(0))
    done = _on_cluster(left, scheduler) if scheduler is not None else _in_processes(left, cores)
    for key, row in done if left else ():
        results[key] = row
        if place and "error" not in row:
            _keep(place / f"{key}.json", row)
        if progress:
            progress(len(results), len(jobs))
    return _table([{**job.labels, **results[job.key]} for job in jobs])


def sweep(scenes: Any, hands: Any, parameters: Any = None, *, rate: float = 1000,
          folder: str | os.PathLike[str] | None = None, scheduler: Any = None, workers: int | None = None,
          measure: Callable[[Any, Any], Row] | None = None,
          progress: Callable[[int, int], None] | None = None) -> Any:
    """Runs every scene with every hand and every set of parameters. Returns one row per run, in this order.

    `scenes`, `hands`: one, a list, or a dict by name; each as for Scene and Hand. `parameters`: keys of the scene with
    their values ({"model": ["offset", "packing"]}: all combinations), or a list of such sets. `folder`: folder of the
    results, from which an interrupted sweep continues. `scheduler`: address of a Dask scheduler, or a Client; the
    files of scenes and hands must then have the same paths on every worker. Otherwise `workers` processes are used
    (default: all cores). `measure(ticks, core)` adds columns; it must be a function of a module. A failed run gives a
    row with `error`, and the next call repeats it.
    """
    return _carry_out(_jobs(scenes, hands, parameters, rate, measure), folder, scheduler, workers, progress)


def _score(program: str, session: str, rules: str | None) -> Row:
    row: Row = json.loads(call(program, "rescore", session, "--json", *(["--rules", rules] if rules else [])))
    items = row.pop("items")
    return {**{key: value for key, value in row.items() if key != "session"}, **items}


def rescore(folder: str | os.PathLike[str], rules: str | os.PathLike[str] | None = None, *, scheduler: Any = None,
            workers: int | None = None, program: str = "typodont",
            progress: Callable[[int, int], None] | None = None) -> Any:
    """Scores all sessions (.h5) below a folder again. Returns one row per session, with its points and their reasons.
    `rules`: a scene whose task or score rules replace the recorded ones. `program`: the program `typodont`."""
    files: Iterable[_File] = sorted(_File(folder).rglob("*.h5"))
    scene = str(_File(rules).resolve()) if rules is not None else None
    jobs = [Job(str(file), {"session": str(file.relative_to(folder))}, _score, (program, str(file.resolve()), scene))
            for file in files]
    return _carry_out(jobs, None, scheduler, workers, progress)
