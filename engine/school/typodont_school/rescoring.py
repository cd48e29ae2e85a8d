"""Scores stored sessions again with the present program, through typodont.rescore() of the Python package."""
import os
import tempfile
from pathlib import Path

from django.conf import settings

from . import intake, program
from .models import Rescore, Session

BATCH = 256  # sessions; an interrupted command continues with the next batch


class NoDoor(Exception):
    """The Python package `typodont` cannot be used."""


def door():
    try:
        import typodont
    except (ImportError, OSError) as problem:
        raise NoDoor(f"the Python package typodont: {problem}")
    return typodont


def rescore_all(scheduler=None):
    """Scores every session that this program has not scored yet; returns their number. `scheduler`: address of a Dask
    scheduler, whose workers see the data folder at the same path."""
    typodont, version, done = door(), program.version(), 0
    places = {name: value for name, value in program.environment().items() if name.startswith("TYPODONT_")}
    os.environ.update(places)
    if scheduler:
        from distributed import Client
        scheduler = Client(scheduler)
        scheduler.run(os.environ.update, places)
    left = Session.objects.filter(state=Session.ACCEPTED, points__isnull=False).exclude(program=version).exclude(rescores__program=version)
    while batch := list(left.order_by("received", "pk")[:BATCH]):
        with tempfile.TemporaryDirectory(dir=intake.folder("work"), prefix="rescore-") as room:
            for session in batch:
                (Path(room) / (session.pk + ".h5")).symlink_to(intake.recording_of(session.pk))
            table = typodont.rescore(room, scheduler=scheduler, program=settings.PROGRAM)
        rows = table.to_dict("records") if hasattr(table, "to_dict") else table
        Rescore.objects.bulk_create(result(row, version) for row in rows)
        done += len(batch)
    return done


def result(row, version):
    sha, error = row["session"].removesuffix(".h5"), row.get("error")
    if isinstance(error, str) and error:
        return Rescore(session_id=sha, program=version, error=error[:300])
    return Rescore(session_id=sha, program=version, points=100 * row["points"] / row["full"], passed=bool(row["passed"]))
