"""What a bench asks: hand-in, exams, and what its operator's window shows to a student."""
import hashlib
import secrets
from datetime import timedelta

from django.core import signing
from django.http import JsonResponse
from django.utils import timezone
from django.views.decorators.csrf import csrf_exempt

from . import intake, views, words
from .access import STUDENT, known, public, role
from .models import Assignment, Bench, ExamStart, Exercise, Session, Student

TOKEN_AGE = timedelta(hours=4)


def bench_of(request):
    scheme, _, token = request.headers.get("Authorization", "").partition(" ")
    bench = Bench.objects.filter(token_hash=hashlib.sha256(token.encode()).hexdigest()).first() if scheme == "Bearer" else None
    if bench is None:
        raise intake.Problem(401, "no bench has this token", code="no_bench")
    if not bench.last_seen or timezone.now() - bench.last_seen > timedelta(minutes=1):
        bench.last_seen = timezone.now()
        bench.save(update_fields=["last_seen"])
    return bench


def interface(*methods):
    def mark(view):
        @public
        @csrf_exempt  # a token, no cookie
        def answered(request, *args, **kwargs):
            try:
                bench = bench_of(request)
                if request.method not in methods:
                    raise intake.Problem(405, " or ".join(methods))
                answer = view(request, bench, *args, **kwargs)
                return JsonResponse(answer) if isinstance(answer, dict) else answer
            except intake.Problem as problem:
                return JsonResponse(problem.answer, status=problem.status)
        return answered
    return mark


@interface("GET", "PUT")
def hand_in(request, bench, sha):
    signature = request.headers.get("X-Signature", "")
    if request.method == "GET":
        return intake.state(sha, bench, signature)
    try:
        kind, _, span = request.headers.get("Content-Range", "").partition(" ")
        first, last, total = (int(n) for n in span.replace("/", "-").split("-"))
        size = int(request.headers.get("Content-Length", ""))
        if kind != "bytes" or size != last - first + 1 or size <= 0 or first < 0:
            raise ValueError
    except ValueError:
        raise intake.Problem(400, "Content-Range: bytes FIRST-LAST/TOTAL")
    if size > intake.MAX_CHUNK:
        raise intake.Problem(413, "chunk too large")
    chunk = request.read(size)
    if len(chunk) != size:
        raise intake.Problem(400, "the body is shorter than announced")
    return intake.append(bench, sha, first, total, chunk, signature)


def exam_scene(start):
    return {**start.assignment.exercise.scene, "exam": start.seed, "warnings": False}


@interface("POST")
def exam(request, bench, key):
    """Starts a sealed exam: the scene with its seed. A second start by the same bench gives the same seed."""
    now = timezone.now()
    pseudonym = request.POST.get("student", "")
    assignment = Assignment.objects.filter(pk=key, sealed=True, opens__lte=now, due__gte=now, group__school=bench.school).first()
    who = Student.objects.filter(pseudonym=pseudonym, classes=assignment.group).first() if assignment else None
    if who is None:
        raise intake.Problem(403, "no open exam for this student", code="not_open")
    start, _ = ExamStart.objects.get_or_create(assignment=assignment, student=who, defaults={"bench": bench, "seed": secrets.token_hex(16)})
    if start.bench_id != bench.pk or start.session_id:
        raise intake.Problem(403, "no open exam for this student", code="not_open")
    return {"seed": start.seed, "scene": exam_scene(start)}


@interface("POST")
def exam_progress(request, bench):
    """A bench announces how much of an exam it has recorded, so that nobody can remove the end later."""
    try:
        seconds = float(request.POST.get("seconds", ""))
        if not 0 <= seconds < 1e6:
            raise ValueError
    except ValueError:
        raise intake.Problem(400, "seconds")
    start = ExamStart.objects.filter(seed=request.POST.get("seed", ""), bench=bench, session=None)
    if not start.exists():
        raise intake.Problem(403, "no open exam with this seed at this bench", code="not_open")
    start.filter(announced_s__lt=seconds).update(announced_s=seconds)
    return {}


# For a student at a bench. A token is valid at one bench, and until the password changes or the account closes.

def token_of(student, bench):
    return signing.dumps([student.pk, bench.pk, student.user.get_session_auth_hash()], salt="student at a bench")


def student_of(request, bench):
    try:
        key, at, proof = signing.loads(request.headers.get("X-Student", ""), salt="student at a bench", max_age=TOKEN_AGE)
    except signing.BadSignature:
        key, at, proof = None, None, ""
    student = Student.objects.filter(pk=key).select_related("user").first() if at == bench.pk else None
    if not student or role(student.user) != STUDENT or not secrets.compare_digest(proof, student.user.get_session_auth_hash()):
        raise intake.Problem(403, "sign in again", code="expired")
    return student


@interface("POST")
def bench_sign_in(request, bench):
    user, error, status = known(request, request.POST.get("name", ""))
    if user and role(user) != STUDENT:
        error, status = "no_student", 403
    if error:
        raise intake.Problem(status, "no student has this name and password" if status == 403 else "too many attempts", code=error)
    return {"student": user.student.pseudonym, "token": token_of(user.student, bench)}


def open_assignments(student):
    """Returns the open assignments of a student, soonest first, with the number of attempts that are left."""
    now = timezone.now()
    found = list(Assignment.objects.filter(group__students=student, opens__lte=now, due__gte=now).order_by("due", "pk").select_related("exercise").distinct())
    for one in found:
        done = Session.objects.filter(student=student, assignment=one, state=Session.ACCEPTED).count()
        one.left = max(0, (1 if one.sealed else one.attempts) - done)
    return found


@interface("GET")
def me(request, bench):
    """A student's scores by exercise, open assignments and last sessions."""
    student, language = student_of(request, bench), words.language_of(request)
    curves = {}
    for exercise, points in views.accepted([student]).order_by("exercise__name", "attempt").values_list("exercise", "points"):
        curves.setdefault(exercise, []).append(round(points, 1))
    names = Exercise.objects.in_bulk(list(curves))
    return {"student": student.pseudonym,
            "curves": [{"title": names[key].title(language), "points": points[-50:]} for key, points in curves.items()],
            "assignments": [{"number": one.pk, "title": one.exercise.title(language), "due": timezone.localtime(one.due).strftime("%Y-%m-%d %H:%M"),
                             "left": one.left, "sealed": one.sealed, "scene": one.exercise.name, "files": one.exercise.is_case or one.sealed}
                            for one in open_assignments(student)]}


@interface("GET")
def assignment_files(request, bench, key):
    """The files of an assigned exercise; of an exam, after its start at this bench."""
    student = student_of(request, bench)
    one = next((one for one in open_assignments(student) if one.pk == key), None)
    start = ExamStart.objects.filter(assignment=one, student=student, bench=bench, session=None).first() if one and one.sealed else None
    if one is None or (one.sealed and not start):
        raise intake.Problem(403, "no open assignment of this student", code="not_open")
    if start:
        return views.packed_case(one.exercise, f"exam-{one.pk}", exam_scene(start))
    return views.packed_case(one.exercise, one.exercise.name, one.exercise.scene)
