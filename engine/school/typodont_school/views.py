"""The pages."""
import csv
import hashlib
import json
import os
import re
import secrets
import shutil
import tempfile
import zipfile
from collections import Counter, defaultdict
from datetime import timedelta
from pathlib import Path
from statistics import fmean

from django.conf import settings
from django.contrib import auth
from django.contrib.auth import password_validation, update_session_auth_hash
from django.core.exceptions import ValidationError
from django.core.serializers.json import DjangoJSONEncoder
from django.db import transaction
from django.db.models import Avg, Count, OuterRef, Subquery
from django.http import FileResponse, HttpResponse, JsonResponse, StreamingHttpResponse
from django.shortcuts import redirect, render
from django.utils import timezone
from django.utils.dateparse import parse_datetime
from django.utils.http import url_has_allowed_host_and_scheme
from django.views.decorators.clickjacking import xframe_options_sameorigin

from . import charts, films, intake, oneroster, program, words, xapi
from .access import ADMIN, ALL, STAFF, STUDENT, get, known, page, public, visible
from .models import (Assignment, Bench, Class, Exercise, Film, Platform, Remark, School, ScoreItem, Session, Student)

DEFECT_SESSIONS = 1000  # last sessions whose defects a page of an exercise shows


def refused(request, exception=None):
    return render(request, "message.html", {"title": "not_allowed", "text": "not_allowed_text"}, status=403)


# Sign-in.

@public
def sign_in(request):
    error, status = None, 200
    onward = request.POST.get("next", request.GET.get("next", "/"))
    if not url_has_allowed_host_and_scheme(onward, {request.get_host()}, request.is_secure()):
        onward = "/"
    if request.method == "POST":
        user, error, status = known(request, request.POST.get("username", ""))
        if user:
            auth.login(request, user)
            return redirect(onward)
    return render(request, "sign_in.html", {"error": error, "next": onward}, status=status)


@public
def language(request):
    answer = redirect("home")
    if request.method == "POST":
        onward = request.POST.get("next", "/")
        if url_has_allowed_host_and_scheme(onward, {request.get_host()}, request.is_secure()):
            answer = redirect(onward)
        if request.POST.get("language") in words.LANGUAGES:
            answer.set_cookie("language", request.POST["language"], max_age=365 * 86400, samesite="Lax", secure=settings.HTTPS)
    return answer


@page(*ALL, methods="POST")
def sign_out(request):
    auth.logout(request)
    return redirect("sign_in")


@page(*ALL, methods="GET POST")
def password(request):
    error = None
    if request.method == "POST":
        new = request.POST.get("new", "")
        try:
            if not request.user.check_password(request.POST.get("old", "")):
                raise ValidationError(words.say(words.language_of(request), "wrong"))
            password_validation.validate_password(new, request.user)
            request.user.set_password(new)
            request.user.save()
            update_session_auth_hash(request, request.user)
            return render(request, "message.html", {"title": "change_password", "text": "changed"})
        except ValidationError as problem:
            error = problem.messages[0]
    return render(request, "password.html", {"error": error}, status=400 if error else 200)


@page(*ALL)
def home(request):
    return redirect("student", request.user.student.pk) if request.role == STUDENT else redirect("classes")


# Teachers' pages.

def accepted(students):
    return Session.objects.filter(student__in=students, state=Session.ACCEPTED, points__isnull=False)


@page(*STAFF)
def classes(request):
    month = timezone.now() - timedelta(days=30)
    rows = list(visible(request.user, Class).order_by("name").select_related("school"))
    last = Session.objects.filter(student=OuterRef("pk")).order_by("-received").values("received")[:1]
    handed_in = defaultdict(list)
    for key, received in Student.objects.filter(classes__in=rows).annotate(last=Subquery(last)).values_list("classes", "last"):
        handed_in[key].append(received)
    recent = {key: (count, mean) for key, count, mean in accepted(Student.objects.all()).filter(received__gt=month, student__classes__in=rows)
              .values_list("student__classes").annotate(Count("pk"), Avg("points"))}
    for row in rows:
        row.size, row.last = len(handed_in[row.pk]), max(filter(None, handed_in[row.pk]), default=None)
        row.recent, row.mean = recent.get(row.pk, (0, None))
    return render(request, "classes.html", {"rows": rows})


@page(*STAFF)
def group(request, key):
    one = get(request.user, Class, key)
    students = list(one.students.order_by("pseudonym"))
    by_student, by_exercise = defaultdict(list), defaultdict(list)
    for student, exercise, points, passed, received in accepted(students).order_by("received").values_list(
            "student", "exercise", "points", "passed", "received"):
        by_student[student].append((points, received))
        by_exercise[exercise].append((points, passed))
    for student in students:
        own = by_student[student.pk]
        student.count = len(own)
        if own:
            student.last_points, student.last = own[-1]
            student.mean = fmean(points for points, _ in own)
            student.spark = charts.spark([points for points, _ in own[-12:]])
    exercises = list(Exercise.objects.filter(pk__in=by_exercise).order_by("name"))
    for exercise in exercises:
        scored = by_exercise[exercise.pk]
        exercise.count, exercise.mean = len(scored), fmean(points for points, _ in scored)
        exercise.passed = 100 * sum(bool(passed) for _, passed in scored) / len(scored)
    assignments = list(one.assignments.order_by("-due").prefetch_related("exercise"))
    for assignment in assignments:
        assignment.done = Session.objects.filter(assignment=assignment, state=Session.ACCEPTED).values("student").distinct().count()
    return render(request, "class.html", {"group": one, "students": students, "exercises": exercises, "assignments": assignments,
                                          "choices": Exercise.objects.order_by("name"), "families": program.families(),
                                          "week": timezone.localtime() + timedelta(days=7)})


def class_curve(students, exercise):
    """Mean points of a class by attempt, with intervals: (attempt, mean, low, high, count)."""
    by_attempt = defaultdict(list)
    for attempt, points in accepted(students).filter(exercise=exercise, attempt__lte=20).values_list("attempt", "points"):
        by_attempt[attempt].append(points)
    return [(attempt, *charts.mean_interval(values), len(values)) for attempt, values in sorted(by_attempt.items())]


@page(*STAFF)
def exercise(request, key, exercise_key):
    one, task = get(request.user, Class, key), get(request.user, Exercise, exercise_key)
    language = words.language_of(request)
    say = lambda text: words.say(language, text)
    scored = accepted(list(one.students.all())).filter(exercise=task)
    points = list(scored.values_list("points", flat=True))
    items = defaultdict(list)
    recent = scored.order_by("-received").values("pk")[:DEFECT_SESSIONS]
    for row in ScoreItem.objects.filter(session__in=recent, full__gt=0).values_list("name", "value", "place", "points", "full", "unit", "target"):
        items[row[0]].append(row)
    defects = []
    for name, rows in items.items():
        _, values, places, points_of, full, (unit, *_), (target, *_) = zip(*rows)
        values, places = [value for value in values if value is not None], Counter(filter(None, places))
        title = words.item(language, name)
        defects.append({"name": name, "title": title, "unit": unit, "lost": fmean(full) - fmean(points_of), "mean": fmean(values) if values else None,
                        "target": target, "place": words.place(language, places.most_common(1)[0][0]) if places else "",
                        "chart": charts.histogram(title, values, f"{title} ({unit})" if unit else title, say("count"), target, say("target"))})
    defects.sort(key=lambda row: -row["lost"])
    curve = class_curve(one.students.all(), task)
    return render(request, "exercise.html", {
        "group": one, "exercise": task, "curve": curve, "defects": defects, "count": len(points), "most": DEFECT_SESSIONS,
        "curve_chart": charts.learning_curve(say("learning_curve"), [row[:4] for row in curve], [], say("attempt"), say("points")),
        "points_chart": charts.histogram(say("distribution"), points, say("points"), say("count"))})


@page(*STAFF, methods="POST")
def assign(request, key):
    one = get(request.user, Class, key)
    try:
        task, due, attempts = int(request.POST["exercise"]), parse_datetime(request.POST["due"]), int(request.POST["attempts"])
    except (KeyError, ValueError):
        return HttpResponse(status=400)
    if due is None or not 0 < attempts <= 100:
        return HttpResponse(status=400)
    task = get(request.user, Exercise, task)
    due = timezone.make_aware(due) if timezone.is_naive(due) else due
    Assignment.objects.create(group=one, exercise=task, due=due, attempts=attempts, sealed="sealed" in request.POST)
    return redirect("class", one.pk)


@page(*STAFF, methods="POST")
def add_case(request, key):
    """Makes an exercise from a family, a seed and a difficulty. It is handed out like any other."""
    one = get(request.user, Class, key)
    try:
        family, seed, percent = request.POST["family"], int(request.POST["seed"]), int(request.POST["difficulty"])
    except (KeyError, ValueError):
        return HttpResponse(status=400)
    if family not in program.families() or not 0 <= seed < 1 << 32 or not 0 <= percent <= 100:
        return HttpResponse(status=400)
    name = f"{family}-{seed}-{percent}"
    file = intake.folder("cases") / (name + ".json")
    try:
        if not file.exists():
            program.make_case(file, family, seed, percent / 100)
    except program.Refused as problem:
        return render(request, "message.html", {"title": "new_case", "detail": str(problem)}, status=400)
    scene = {**json.loads(file.read_text()), "name": name}
    tissue = hashlib.sha256(file.with_suffix(".vdb").read_bytes()).hexdigest()
    Exercise.objects.update_or_create(name=name, defaults={"scene": scene, "files": {name + ".vdb": tissue}})
    return redirect("class", one.pk)


@page(*ALL)
def case_files(request, key):
    """The scene of a case with its tissue, for a bench: one zip file."""
    task = get(request.user, Exercise, key)
    return packed_case(task, task.name, task.scene) if task.is_case else HttpResponse(status=409)


def packed_case(task, name, scene):
    """A zip file with the scene and the case's tissue."""
    out = tempfile.TemporaryFile(dir=intake.folder("work"))
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as packed:
        packed.writestr(name + ".json", json.dumps(scene, ensure_ascii=False, indent=1))
        if task.is_case:
            packed.write(intake.folder("cases") / (task.name + ".vdb"), task.name + ".vdb")
    out.seek(0)
    return FileResponse(out, as_attachment=True, filename=name + ".zip")


SCORES = "pseudonym exercise attempt received points passed completion seconds sha256".split()


def scores_of(group):
    return accepted(group.students.all()).order_by("received").values_list(
        "student__pseudonym", "exercise__name", "attempt", "received", "points", "passed", "completion", "seconds", "sha256")


@page(*STAFF)
def scores_json(request, key):
    """Columns of scores, from which the page writes a Parquet file."""
    rows = list(scores_of(get(request.user, Class, key)))
    return JsonResponse({name: [row[i] for row in rows] for i, name in enumerate(SCORES)})


@page(*STAFF)
def scores_csv(request, key):
    rows = scores_of(get(request.user, Class, key))
    answer = HttpResponse(content_type="text/csv; charset=utf-8", headers={"Content-Disposition": 'attachment; filename="scores.csv"'})
    out = csv.writer(answer)
    out.writerow(SCORES)
    for row in rows:
        out.writerow(plain_cell(cell) for cell in row)
    return answer


def plain_cell(cell):
    """A text that a spreadsheet takes for no formula."""
    return "'" + cell if isinstance(cell, str) and cell[:1] in "=+-@\t\r" and cell else cell


@page(*STAFF)
def statements(request, key):
    one = get(request.user, Class, key)
    found = accepted(one.students.all())
    items = defaultdict(dict)
    for sha, name, value in ScoreItem.objects.filter(session__in=found).values_list("session", "name", "value"):
        items[sha][name] = value
    sessions = found.select_related("student").prefetch_related("exercise").defer("defects").order_by("received")
    return JsonResponse([xapi.statement(session, items[session.pk]) for session in sessions], safe=False)


# Students' pages.

@page(*ALL)
def student(request, key):
    one = get(request.user, Student, key)
    language = words.language_of(request)
    sessions = list(Session.objects.filter(student=one).order_by("-received").prefetch_related("exercise").defer("defects")[:100])
    by_exercise = defaultdict(list)
    for task, attempt, points, sha in accepted([one]).filter(attempt__lte=20).order_by("attempt").values_list(
            "exercise", "attempt", "points", "sha256"):
        by_exercise[task].append((attempt, points, f"{attempt}: {points:.0f}"))
    group = one.classes.first()
    curves = []
    for task in Exercise.objects.filter(pk__in=by_exercise).order_by("name"):
        own = by_exercise[task.pk]
        others = class_curve(group.students.all(), task) if group else []
        if request.role == STUDENT:
            others = [row for row in others if row[4] >= charts.MIN_VALUES]
        curves.append({"title": task.title(language), "own": own, "chart": charts.learning_curve(
            task.title(language), [row[:4] for row in others], own, words.say(language, "attempt"), words.say(language, "points"))})
    assignments = list(Assignment.objects.filter(group__students=one).order_by("-due").prefetch_related("exercise"))
    for assignment in assignments:
        mine = [s for s in sessions if s.assignment_id == assignment.pk and s.state == Session.ACCEPTED]
        assignment.done, assignment.best = len(mine), max((s.points for s in mine if s.points is not None), default=None)
    return render(request, "student.html", {"student": one, "sessions": sessions, "curves": curves, "assignments": assignments})


@page(*ALL)
def session(request, key):
    one = get(request.user, Session, key)
    items = sorted(one.items.all(), key=lambda item: item.points - item.full)
    for item in items:
        item.percent = 100 * item.points / item.full if item.full else None
    return render(request, "session.html", {"session": one, "film": Film.objects.filter(pk=one.pk).first(), "items": [i for i in items if i.full > 0], "others": [i for i in items if i.full <= 0],
                                            "rescores": [again for again in one.rescores.order_by("at") if again.differs],
                                            "remarks": one.remarks.order_by("written").select_related("author")})


def accepted_session(user, key):
    one = get(user, Session, key)
    return one if one.state == Session.ACCEPTED else None


@page(*ALL)
@xframe_options_sameorigin
def report(request, key):
    """The program's own page, made on first use. Its texts come from a recording, so it runs in a sandbox."""
    one = accepted_session(request.user, key)
    if not one:
        return HttpResponse(status=409)
    file = intake.derived(one.sha256, words.language_of(request) + ".html")
    if not file.exists():
        with tempfile.TemporaryDirectory(dir=intake.folder("work"), prefix="report-") as room:
            made = Path(room) / file.name
            program.score(intake.recording_of(one.sha256), made)
            made.replace(file)
    answer = FileResponse(file.open("rb"), content_type="text/html; charset=utf-8")
    answer["Content-Security-Policy"] = "sandbox allow-scripts; default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'unsafe-inline'; media-src data:"
    return answer


@page(*ALL, methods="GET POST")
def film(request, key):
    """Asks for the film, or says its state."""
    one = accepted_session(request.user, key)
    if not one:
        return HttpResponse(status=409)
    if request.method == "POST":
        if not films.ask(one, request.user, words.language_of(request)):
            return render(request, "message.html", {"title": "film", "text": "too_many_films"}, status=429)
        return redirect("session", one.pk)
    asked = Film.objects.filter(pk=one.pk).first()
    return JsonResponse({"state": asked.state if asked else "none"})


def span(file, left):
    """The next bytes of a file."""
    with file:
        while left and (block := file.read(min(left, 1 << 16))):
            left -= len(block)
            yield block


@page(*ALL)
def film_file(request, key):
    """Answers one range of bytes, so that a browser can seek."""
    one = get(request.user, Session, key)
    try:
        file = films.file_of(one.pk).open("rb")
    except FileNotFoundError:
        return HttpResponse(status=409)
    total = os.fstat(file.fileno()).st_size
    first, last, headers = 0, total - 1, {"Accept-Ranges": "bytes"}
    asked = re.fullmatch(r"bytes=(\d{0,15})-(\d{0,15})", request.headers.get("Range", ""), re.ASCII)
    if asked and any(asked.groups()):
        if asked[1]:
            first, last = int(asked[1]), min(int(asked[2] or last), last)
        else:
            first = max(0, total - int(asked[2]))
        if first > last:
            file.close()
            return HttpResponse(status=416, headers={"Content-Range": f"bytes */{total}"})
        headers["Content-Range"] = f"bytes {first}-{last}/{total}"
    file.seek(first)
    headers["Content-Length"] = last - first + 1
    return StreamingHttpResponse(span(file, last - first + 1), status=206 if "Content-Range" in headers else 200,
                                 content_type="video/mp4", headers=headers)


@page(*ALL)
def recording(request, key):
    one = get(request.user, Session, key)
    return FileResponse(intake.recording_of(one.sha256).open("rb"), as_attachment=True, filename=one.sha256[:12] + ".h5")


@page(*STAFF, methods="POST")
def remark(request, key):
    """Adds a remark, or changes the one of this number. Without a text, it is removed."""
    one = get(request.user, Session, key)
    text = request.POST.get("text", "").strip()[:4000]
    try:
        at_s = float(request.POST["at_s"]) if request.POST.get("at_s") else None
        if at_s is not None and not 0 <= at_s <= 86400:
            raise ValueError
        number = int(request.POST.get("number", "0"))
    except ValueError:
        return HttpResponse(status=400)
    old = one.remarks.filter(pk=number)
    if not text:
        old.delete()
    elif number:
        old.update(text=text, at_s=at_s, author=request.user, written=timezone.now())
    else:
        Remark.objects.create(session=one, author=request.user, text=text, at_s=at_s)
    return redirect("session", one.pk)


@page(*ALL)
def remarks(request, key):
    """For the file beside a recording that the program's report reads."""
    one = get(request.user, Session, key)
    answer = JsonResponse({"remarks": [r.row() for r in one.remarks.order_by("written").select_related("author")]})
    answer["Content-Disposition"] = f'attachment; filename="{one.sha256[:12]}.h5.remarks.json"'
    return answer


def plain(rows, names):
    return [{name: getattr(row, name) for name in names.split()} for row in rows.all()]


@page(*ALL)
def export(request, key):
    """Everything stored about a student: one zip file."""
    one = get(request.user, Student, key)
    rows = [{"sha256": s.sha256, "received": s.received.isoformat(), "bench": s.bench.name, "bench_date": s.bench_date, "state": s.state, "reason": s.reason,
             "exercise": s.exercise and s.exercise.name, "attempt": s.attempt, "points": s.points, "passed": s.passed, "seconds": s.seconds,
             "items": plain(s.items, "name value unit target points full place"), "defects": s.defects, "program": s.program,
             "rescores": plain(s.rescores, "program at points passed error"), "remarks": [r.row() for r in s.remarks.all()]}
            for s in one.session_set.select_related("bench").prefetch_related("exercise", "items", "rescores", "remarks__author")]
    about = {"pseudonym": one.pseudonym, "identifier": one.source_id, "user": one.user and one.user.username,
             "classes": [c.name for c in one.classes.all()], "sessions": rows}
    out = tempfile.TemporaryFile(dir=intake.folder("work"))
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as packed:
        packed.writestr("student.json", json.dumps(about, ensure_ascii=False, indent=1, cls=DjangoJSONEncoder))
        for row in rows:
            file = intake.recording_of(row["sha256"])
            if file.exists():
                packed.write(file, f"recordings/{row['sha256']}.h5")
    out.seek(0)
    return FileResponse(out, as_attachment=True, filename="student.zip")


def erase(one):
    """Deletes a student, the account, and every file of every session."""
    shas = list(one.session_set.values_list("pk", flat=True))
    with transaction.atomic():
        if one.user:
            one.user.delete()
        one.session_set.all().delete()
        one.delete()
    for sha in shas:
        intake.recording_of(sha).unlink(missing_ok=True)
        shutil.rmtree(intake.derived(sha, ""), ignore_errors=True)


@page(ADMIN, methods="POST")
def delete(request, key):
    one = get(request.user, Student, key)
    if request.POST.get("pseudonym") != one.pseudonym:
        return redirect("student", one.pk)
    erase(one)
    return redirect("classes")


# The administration.

@page(ADMIN)
def administration(request):
    return render(request, "administration.html", {
        "benches": Bench.objects.order_by("name"), "platforms": Platform.objects.order_by("issuer"),
        "unclaimed": Session.objects.filter(student=None).order_by("-received").select_related("bench")[:50]})


def own_school():
    return School.objects.order_by("pk").first() or School.objects.create(name="School")


def new_bench(school, name):
    """Returns the bench and its token, which only the bench keeps."""
    token = secrets.token_urlsafe(32)
    return Bench.objects.create(school=school, name=name, token_hash=hashlib.sha256(token.encode()).hexdigest(),
                                signing_key=secrets.token_hex(32)), token


@page(ADMIN, methods="POST")
def add_bench(request):
    bench, token = new_bench(own_school(), request.POST.get("name", "")[:100] or "bench")
    return render(request, "bench.html", {"bench": bench, "token": token})


@page(ADMIN, methods="POST")
def add_class(request):
    name, teacher = request.POST.get("name", "").strip()[:100], request.POST.get("teacher", "").strip()
    people = []
    with transaction.atomic():
        if teacher:
            user = auth.models.User.objects.filter(username=teacher, is_staff=True, is_active=True).first()
            if user is None:
                return render(request, "message.html", {"title": "new_class", "text": "no_teacher"}, status=400)
        else:
            user = oneroster.account(name, people, is_staff=True)
        group = Class.objects.create(school=own_school(), name=name or "class")
        group.teachers.add(user)
    return render(request, "accounts.html", {"people": people, "group": group})


@page(ADMIN, methods="POST")
def add_students(request, key):
    """Adds known students by pseudonym, and makes accounts for all others."""
    group, people = get(request.user, Class, key), []
    lines = [line.strip()[:100] for line in request.POST.get("students", "").splitlines()]
    with transaction.atomic():
        for line in list(dict.fromkeys(filter(None, lines)))[:1000]:
            known = Student.objects.filter(pseudonym=line).first()
            if known is None:
                user = oneroster.account(line, people)
                known = Student.objects.create(pseudonym=user.username, user=user)
            group.students.add(known)
    return render(request, "accounts.html", {"people": people, "group": group})


@page(ADMIN, methods="POST")
def roster(request):
    upload = request.FILES.get("file")
    try:
        people = oneroster.read(upload)
    except oneroster.Unreadable as problem:
        return render(request, "message.html", {"title": "import_roster", "detail": str(problem)}, status=400)
    return render(request, "accounts.html", {"people": people})


@page(ADMIN, methods="POST")
def add_platform(request):
    """Registers a learning system from its settings as JSON, or renews its keys."""
    try:
        given = json.loads(request.POST.get("settings", ""))
        texts = {name: str(given[name]) for name in ("issuer", "client_id", "deployment", "sign_in_url", "token_url")}
        keys = {"keys": [dict(key) for key in given["keys"]]}
    except (ValueError, KeyError, TypeError) as problem:
        return render(request, "message.html", {"title": "new_platform", "detail": str(problem)}, status=400)
    Platform.objects.update_or_create(issuer=texts.pop("issuer"), client_id=texts.pop("client_id"), defaults={**texts, "keys": keys})
    return redirect("administration")


@public
def profile(request):
    return JsonResponse(xapi.profile())
