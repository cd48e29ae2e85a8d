"""Takes recordings in: bytes first, then the checks. Every step can be repeated after a crash."""
import errno
import fcntl
import logging
import os
import shutil
import tempfile
import threading
import time
from pathlib import Path

from django.conf import settings
from django.db import close_old_connections, transaction

from . import lti, program
from .hand_in import sha256
from .models import Assignment, ExamStart, Exercise, ScoreItem, Session, Student

MAX_CHUNK = 4 << 20
MAX_INCOMPLETE = 256  # uploads
ABANDONED = 86400  # s since the last byte of an upload that its bench begins again
CLOCK_ERROR = 0.01  # s, between a bench's announcement and its recording
RATE_ERROR = 0.02  # of a recording's time, which `replay --check` allows
log = logging.getLogger("typodont_school")


class Problem(Exception):
    def __init__(self, status, text, **more):
        super().__init__(text)
        self.status, self.answer = status, {"error": text, **more}


def folder(name):
    path = settings.DATA / name
    path.mkdir(parents=True, exist_ok=True, mode=0o700)
    return path


def recording_of(sha):
    return folder("sessions/" + sha[:2]) / (sha + ".h5")


def need_disk():
    """On a full disk, the program fails for reasons that say nothing about the recording."""
    if shutil.disk_usage(folder("work")).free < settings.MIN_FREE_BYTES:
        raise OSError(errno.ENOSPC, "the disk is full")


def derived(sha, name):
    """A file that was computed from a recording."""
    return folder(f"derived/{sha[:2]}/{sha}") / name


def state(sha, bench, signature):
    """Returns what is known of a session. One that was refused is checked again with another signature, or of another bench."""
    part = folder("incoming") / sha
    received = part.stat().st_size if part.exists() else 0
    session = Session.objects.filter(pk=sha).first() or (received and enter(bench, sha, signature))
    if session:
        if session.state == Session.REFUSED and signature and (signature, bench) != (session.signature, session.bench):
            session.bench, session.signature, session.state = bench, signature[:300], Session.WAITING
            session.save(update_fields=["bench", "signature", "state"])
            worker.wake.set()
        return {"state": session.state, "received": session.size, "reason": session.reason}
    return {"state": "incomplete", "received": received, "reason": ""}


def enter(bench, sha, signature):
    """Returns the session of an upload whose bytes are complete; also after a crash between the last byte and the row."""
    part = folder("incoming") / sha
    if sha256(part) != sha:
        return None
    session, _ = Session.objects.get_or_create(pk=sha, defaults={"bench": bench, "size": part.stat().st_size, "signature": signature[:300]})
    settle(sha)
    worker.wake.set()
    return session


def incomplete(incoming):
    """Returns the number of incomplete uploads, after a clean-up if there are too many."""
    uploads = list(incoming.iterdir())
    if len(uploads) >= MAX_INCOMPLETE:
        for part in uploads:
            if Session.objects.filter(pk=part.name).exists():
                settle(part.name)
            elif time.time() - part.stat().st_mtime > ABANDONED:
                part.unlink(missing_ok=True)
        uploads = list(incoming.iterdir())
    return len(uploads)


def append(bench, sha, first, total, chunk, signature):
    """Appends bytes to an upload; with the last one, the session waits for its checks."""
    if Session.objects.filter(pk=sha).exists():
        return state(sha, bench, signature)
    if not 0 < total <= settings.MAX_SESSION_BYTES or first + len(chunk) > total:
        raise Problem(413, "too large")
    incoming = folder("incoming")
    part = incoming / sha
    if not part.exists() and incomplete(incoming) >= MAX_INCOMPLETE:
        raise Problem(429, "too many incomplete uploads")
    if shutil.disk_usage(incoming).free < total - first + settings.MIN_FREE_BYTES:
        raise Problem(507, "the disk is full")
    with open(part, "ab") as out:
        try:
            fcntl.flock(out, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise Problem(409, "another upload of this session is running")
        if Session.objects.filter(pk=sha).exists():  # another upload was faster
            settle(sha)
            return state(sha, bench, signature)
        have = os.fstat(out.fileno()).st_size
        if first != have:
            raise Problem(409, "not the next byte", received=have)
        try:
            out.write(chunk)
            out.flush()
            os.fsync(out.fileno())
        except OSError:
            os.ftruncate(out.fileno(), have)
            raise Problem(507, "the disk is full", received=have)
        if first + len(chunk) < total:
            return {"state": "incomplete", "received": first + len(chunk), "reason": ""}
        if not enter(bench, sha, signature):
            part.unlink()
            raise Problem(422, "the bytes do not have this SHA-256")
    return state(sha, bench, signature)


def settle(sha):
    """Moves a complete upload, whose row exists, to its place; also after a crash between row and move."""
    part = folder("incoming") / sha
    try:
        os.link(part, recording_of(sha))
    except FileExistsError:  # the part is of a second, slower upload
        pass
    except FileNotFoundError:  # moved already
        return
    part.unlink(missing_ok=True)


def own_rules(scene):
    return {key: value for key, value in scene.items() if key not in ("exam", "warnings")}


def exercise_of(header):
    """Returns the exercise whose scene and files the recording has, byte for byte."""
    scene = header["scene"]
    found = Exercise.objects.filter(name=str(scene.get("name", ""))[:100]).first()
    if not found or own_rules(found.scene) != own_rules(scene):
        return None
    recorded = {str(row["path"]): str(row["hash"]).removeprefix("sha256:") for row in header["files"][1:]}
    return found if all(recorded.get(path) == sha for path, sha in found.files.items()) else None


def exam_of(header):
    """Returns the started exam whose seed the recording's scene carries."""
    return ExamStart.objects.filter(seed=str(header["scene"].get("exam", ""))).select_related("assignment", "student").first()


def judge(session):
    """Checks and scores a session by its recording alone. Raises Refused."""
    with tempfile.TemporaryDirectory(dir=folder("work"), prefix="judge-") as room:
        copy = Path(room) / "session.h5"
        os.link(recording_of(session.sha256), copy)
        key = None
        if session.signature:
            copy.with_name("session.h5.sig").write_text(session.signature + "\n")
            key = Path(room) / "key"
            key.touch(mode=0o600)
            key.write_text(session.bench.signing_key + "\n")
        check = program.check(copy, key)
        if not check["same_force_law"]:
            raise program.Refused("of another version of the force law")
        if not check["identical"]:
            raise program.Refused("the replay differs: " + str(check.get("difference", ""))[:250])
        header = program.header(copy)
        session.student = Student.objects.filter(pseudonym=header["trainee"]).first() if header["trainee"] else None
        session.exercise = exercise_of(header)
        session.scene_name = str(header["scene"].get("name", ""))[:100]
        session.bench_date = header["date"]
        session.seconds, session.truncated = check["seconds"], check["truncated"]
        session.force_hash = header["first_forces"] or check["force_hash"]
        twin = Session.objects.filter(force_hash__in=(session.force_hash, check["force_hash"]), state=Session.ACCEPTED).exclude(pk=session.pk)
        if twin.exists():
            raise program.Refused("the hand of an earlier session")
        exam = exam_of(header)
        if exam:
            _judge_exam(session, exam, header["scene"])
        page = Path(room) / "en.html"
        score = program.score(copy, page)
        if session.exercise and score["full"] > 0:
            session.points = 100 * score["points"] / score["full"]
            session.passed, session.completion = score["passed"], score["completion"]
            session.program = program.version()
        session.defects = [defect_of(defect) for defect in score["defects"]]
        page.replace(derived(session.sha256, "en.html"))
    return score, exam


def _judge_exam(session, exam, scene):
    if not session.signature:
        raise program.Refused("an exam without the bench's signature")
    if session.bench_id != exam.bench_id:
        raise program.Refused("an exam from another bench")
    if session.student_id != exam.student_id:
        raise program.Refused("an exam of another student")
    if session.exercise_id != exam.assignment.exercise_id:
        raise program.Refused("another exercise than the exam's")
    if scene.get("warnings") is not False:
        raise program.Refused("an exam with warnings")
    if session.truncated:
        raise program.Refused("an exam that was cut off")
    if exam.session_id not in (None, session.pk):
        raise program.Refused("a second session of one exam")
    if session.received > exam.assignment.due:
        raise program.Refused("after the exam's end")
    if session.seconds * (1 - RATE_ERROR) > (session.received - exam.started).total_seconds():
        raise program.Refused("longer than the time since the exam's start")
    if session.seconds < exam.announced_s - CLOCK_ERROR:
        raise program.Refused("shorter than its bench announced")


def attach(session):
    """Numbers the attempt, and finds the open assignment with attempts left that the session answers."""
    others = Session.objects.filter(student=session.student, exercise=session.exercise, state=Session.ACCEPTED)
    session.attempt = others.exclude(pk=session.pk).count() + 1
    for assignment in Assignment.objects.filter(group__students=session.student, exercise=session.exercise, sealed=False,
                                                opens__lte=session.received, due__gte=session.received).order_by("due"):
        if others.filter(assignment=assignment).count() < assignment.attempts:
            return assignment
    return None


def process(session):
    settle(session.pk)
    need_disk()
    try:
        score, exam = judge(session)
        session.state, session.reason = Session.ACCEPTED, ""
    except (program.Refused, ValueError, KeyError, TypeError, AttributeError) as refusal:
        need_disk()
        session.state, session.reason = Session.REFUSED, (str(refusal) or "unreadable")[:300]
        score, exam, session.points, session.passed = None, None, None, None
    with transaction.atomic():
        if score and session.student and session.exercise:
            session.assignment = exam.assignment if exam else attach(session)
            if exam:
                attach(session)
                ExamStart.objects.filter(pk=exam.pk).update(session=session)
        session.save()
        session.items.all().delete()
        if score:
            ScoreItem.objects.bulk_create(item_of(session, item) for item in score["items"])
            lti.queue_grade(session)


def place_keys(place):
    return " ".join(f"{key}.{place[key]}" for key in ("part", "side", "third") if place.get(key))


def defect_of(defect):
    """What a session's page shows of a defect."""
    strokes = [{"at_s": float(s["worst_s"]), "tool": str(s["tool"])[:60], "force_N": float(s["force_N"])} for s in defect["strokes"]]
    return {"name": str(defect["name"])[:60], "amount": float(defect["amount"]), "unit": str(defect["unit"])[:20], "left": bool(defect["left"]),
            "place": place_keys(defect.get("at") or {}), "strokes": strokes}


def item_of(session, item):
    return ScoreItem(session=session, name=item["name"][:60], value=item.get("value"), unit=item.get("unit", "")[:20],
                     target=item.get("target"), points=item["points"], full=item["full"], critical=item["critical_error"],
                     place=place_keys(item.get("worst_at") or {})[:60])


def process_waiting():
    """Handles every waiting session; returns their number. One that cannot be handled now does not stop the others."""
    done, failed, waiting = 0, {}, Session.objects.filter(state=Session.WAITING).order_by("received")
    while session := waiting.exclude(pk__in=list(failed)).first():
        try:
            process(session)
            done += 1
        except Exception as problem:
            failed[session.pk] = problem
    for problem in failed.values():
        raise problem
    return done


class Worker(threading.Thread):
    """Does a work beside the pages: when it is woken, and every `period` seconds."""
    def __init__(self, name, work, period):
        super().__init__(daemon=True, name=name)
        self.work, self.period, self.wake = work, period, threading.Event()

    def run(self):
        while True:
            try:
                self.work()
            except Exception:  # a full disk or a locked database: the work waits
                log.exception(self.name)
            close_old_connections()
            self.wake.wait(self.period)
            self.wake.clear()


def check_and_grade():
    process_waiting()
    lti.send_grades()


worker = Worker("intake", check_and_grade, 15)
