"""Copies the data of a running service into a folder. The folder is itself the data of a service."""
import contextlib
import os
import shutil
import sqlite3

from django.conf import settings

KEYS = ("secret.key", "lti.pem")
DATABASE = "school.sqlite"


class Unusable(Exception):
    """The folder cannot be a backup of this service."""


def copy(source, target):
    """Copies a file completely or not at all."""
    target.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    part = target.with_name(target.name + ".part")
    shutil.copy2(source, part)
    with open(part, "rb") as written:
        os.fsync(written.fileno())
    os.replace(part, target)


def back_up(out):
    """Brings a folder up to date: first the rows, then the files that they name. Returns the number of new files."""
    if settings.DATABASES["default"]["ENGINE"] != "django.db.backends.sqlite3":
        raise Unusable("this command copies SQLite only; for PostgreSQL run pg_dump, then copy the data folder")
    if out.exists() and any(out.iterdir()) and (not (out / KEYS[0]).exists() or (out / KEYS[0]).read_text() != settings.SECRET_KEY):
        raise Unusable(f"{out} has other files than a backup of this service")
    if settings.DATA in (out, *out.parents):
        raise Unusable(f"{out} is inside the data folder")
    out.mkdir(parents=True, exist_ok=True)
    out.chmod(0o700)
    for name in KEYS:
        if (settings.DATA / name).exists():
            copy(settings.DATA / name, out / name)
    part = out / (DATABASE + ".part")
    part.unlink(missing_ok=True)
    existing = (settings.DATA / DATABASE).as_uri() + "?mode=rw"
    with contextlib.closing(sqlite3.connect(existing, uri=True)) as live, contextlib.closing(sqlite3.connect(part)) as kept:
        live.backup(kept)
        kept.execute("delete from typodont_school_film")  # films can be made again
        kept.commit()
        rows = {row[0] for row in kept.execute("select sha256 from typodont_school_session")}
    new = 0
    for sha in rows:  # a crash can leave a complete upload that is not moved yet
        for source in (settings.DATA / "incoming" / sha, settings.DATA / "sessions" / sha[:2] / (sha + ".h5")):
            target = out / "sessions" / sha[:2] / (sha + ".h5")
            with contextlib.suppress(FileNotFoundError):  # moved meanwhile, or deleted
                if not target.exists():
                    copy(source, target)
                    new += 1
    for source in (settings.DATA / "cases").glob("*"):
        if not (out / "cases" / source.name).exists():
            copy(source, out / "cases" / source.name)
    os.replace(part, out / DATABASE)
    for file in (out / "sessions").glob("*/*.h5"):  # deleted with a student's data
        if file.stem not in rows:
            file.unlink()
    return new
