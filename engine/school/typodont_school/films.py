"""Makes films of sessions, one at a time, for people who ask. The queue is in the database."""
import shutil
import tempfile
from pathlib import Path

from django.conf import settings
from django.db import transaction
from django.db.models import Sum
from django.utils import timezone

from . import intake, program
from .models import Film

MAX_WAITING = 5  # films that one person may have in the queue
IN_QUEUE = (Film.WAITING, Film.MAKING)
RIGS = {"hip": "hip_window"}  # a scene's own rig -> one with a single picture


def file_of(sha):
    return intake.derived(sha, "film.mp4")


def ask(session, user, language):
    """Puts the film of an accepted session into the queue. False: the person has too many films in it."""
    film = Film.objects.filter(pk=session.pk).first()
    if film and film.state != Film.FAILED:
        return True
    if Film.objects.filter(asked_by=user, state__in=IN_QUEUE).count() >= MAX_WAITING:
        return False
    Film.objects.update_or_create(session=session, defaults={"asked": timezone.now(), "asked_by": user, "language": language,
                                                             "state": Film.WAITING, "reason": "", "size": 0})
    maker.wake.set()
    return True


def make(film):
    """Makes one film. A session that is deleted meanwhile leaves no file."""
    sha = film.session_id
    try:
        with tempfile.TemporaryDirectory(dir=intake.folder("work"), prefix="film-") as room:
            if shutil.disk_usage(room).free < settings.MIN_FREE_BYTES + program.FILM_LIMITS[program.resource.RLIMIT_FSIZE]:
                raise program.Refused("the disk is full")
            recording, out = intake.recording_of(sha), Path(room) / "film.mp4"
            rig = RIGS.get(program.header(recording)["scene"].get("rig"), "window")
            program.film(recording, out, film.session.seconds, rig, film.language)
            state, reason, size = Film.READY, "", out.stat().st_size
            out.replace(file_of(sha))
    except (program.Refused, OSError, ValueError, KeyError, TypeError, AttributeError) as refusal:
        state, reason, size = Film.FAILED, (str(refusal) or "unreadable")[:300], 0
    if not Film.objects.filter(pk=sha).update(state=state, reason=reason, size=size):
        shutil.rmtree(intake.derived(sha, ""), ignore_errors=True)


def make_room():
    """Deletes the oldest films above the limit of all films; they can be asked for again."""
    ready = Film.objects.filter(state=Film.READY)
    while (ready.aggregate(all=Sum("size"))["all"] or 0) > settings.MAX_FILMS_BYTES:
        with transaction.atomic():
            oldest = ready.order_by("asked").first()
            file_of(oldest.pk).unlink(missing_ok=True)
            oldest.delete()


def make_waiting():
    """Makes every waiting film, and again the one that a killed service was making; returns their number."""
    done = 0
    while film := Film.objects.filter(state__in=IN_QUEUE).order_by("asked").select_related("session").first():
        Film.objects.filter(pk=film.pk).update(state=Film.MAKING)
        make(film)
        make_room()
        done += 1
    return done


maker = intake.Worker("films", make_waiting, 60)
