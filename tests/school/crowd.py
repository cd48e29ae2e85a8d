"""A crowd of sessions, made by varying the records of real recordings: for tests of load and for pictures."""
import hashlib
import random
from datetime import timedelta

from django.utils import timezone

from room import user
from typodont_school.models import Class, ScoreItem, Session, Student


def crowd(room, models, classes, students, sessions):
    """Adds `sessions` sessions of `students` in each of `classes`; models are judged sessions of real recordings."""
    dice, now = random.Random(68), timezone.now()
    people = []
    for c in range(classes):
        group = Class.objects.create(school=room.school, name=f"Year {3 + c % 3}, group {c + 1}")
        group.teachers.add(room.teacher_A)
        for s in range(students):
            student = Student.objects.create(pseudonym=f"s-{c + 1:02d}{s + 1:02d}", user=user(f"s-{c + 1:02d}{s + 1:02d}") if c == s == 0 else None)
            student.classes.add(group)
            people.append((student, dice.gauss(0, 8), dice.uniform(0.5, 1.5)))
    items = {model.pk: list(model.items.all()) for model in models}
    rows, parts, attempts = [], [], {}
    for number in range(sessions):
        student, talent, pace = people[number % len(people)]
        model = models[(number // len(people)) % len(models)]
        attempt = attempts[student.pk, model.exercise_id] = attempts.get((student.pk, model.exercise_id), 0) + 1
        skill = 1 - 0.6 / (1 + 0.35 * pace * (attempt - 1))  # a power-like learning curve
        one = Session(sha256=hashlib.sha256(b"%d" % number).hexdigest(), bench=room.bench, size=model.size, state=Session.ACCEPTED, student=student,
                      exercise=model.exercise, scene_name=model.scene_name, attempt=attempt, seconds=model.seconds * dice.uniform(0.8, 2.5),
                      received=now - timedelta(days=180) * (1 - number / sessions), completion=1)
        total = 0
        for item in items[model.pk]:
            share = min(1, max(0, skill + talent / 100 + dice.gauss(0, 0.12)))
            points = item.full * share
            total += points
            tolerance = abs((item.value or 0) - (item.target or 0)) + 0.3 * abs(item.target or 1)
            parts.append(ScoreItem(session=one, name=item.name, unit=item.unit, target=item.target, full=item.full, points=points,
                                   value=(item.target or 0) + (1.05 - share) * tolerance,
                                   place=dice.choice(("part.wall side.mesial third.middle", "part.floor side.central", "part.wall side.distal third.cervical")) if item.place else ""))
        one.points, one.passed = total, total >= 60
        rows.append(one)
        if len(parts) > 20_000:
            Session.objects.bulk_create(rows)
            ScoreItem.objects.bulk_create(parts, batch_size=2000)
            rows, parts = [], []
    Session.objects.bulk_create(rows)
    ScoreItem.objects.bulk_create(parts, batch_size=2000)
    return [student for student, _, _ in people]
