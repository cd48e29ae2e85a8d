"""Sealed exams: a forged session never gets a mark, an honest one always does."""
import json
import os
import pathlib
import random
import shutil
import subprocess
import tempfile
from collections import Counter
from datetime import timedelta

import h5py
from django.conf import settings
from django.test import TestCase
from django.utils import timezone

from room import Room, record
from typodont_school import views
from typodont_school.models import Assignment, ExamStart, Session, Student

STRESS = float(os.environ.get("TYPODONT_STRESS", 1))


class Exams(TestCase):
    def setUp(self):
        self.room = Room()
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.exam = Assignment.objects.create(group=self.room.class_A, exercise=self.room.exercise, due=timezone.now() + timedelta(days=1),
                                              attempts=1, sealed=True)

    def start(self, student, token=None):
        return self.client.post(f"/api/exam/{self.exam.pk}", {"student": student.pseudonym}, HTTP_AUTHORIZATION="Bearer " + (token or self.room.token))

    def record(self, student, seed):
        """What the bench records and announces: the exam's scene with its seed."""
        scene = self.folder / student.pseudonym / "class-1-cavity.json"
        scene.parent.mkdir(exist_ok=True)
        scene.write_text(json.dumps(self.start(student).json()["scene"]))
        ExamStart.objects.filter(student=student).update(started=timezone.now() - timedelta(minutes=1))  # the program's hand works faster than real time
        file = record(f"exam-{student.pseudonym}-{os.urandom(4).hex()}", student.pseudonym, seed, scene)
        with h5py.File(file) as f:
            self.assertEqual(self.announce(self.start(student).json()["seed"], f["ticks/t_s"][-1]).status_code, 200)
        return shutil.copy(file, self.folder)

    def announce(self, seed, seconds, token=None):
        return self.client.post("/api/exam/progress", {"seed": seed, "seconds": seconds}, HTTP_AUTHORIZATION="Bearer " + (token or self.room.token))

    def sign(self, file, key=None):
        path = self.folder / "key"
        path.unlink(missing_ok=True)
        path.touch(mode=0o600)
        path.write_text((key or self.room.bench.signing_key) + "\n")
        subprocess.run([settings.PROGRAM, "sign", "--key", path, file], check=True, capture_output=True)
        return pathlib.Path(str(file) + ".sig").read_text().strip()

    def test_an_honest_exam_counts_once(self):
        file = self.record(self.room.anna, 0)
        session = self.room.judged(file, self.sign(file))
        self.assertEqual((session.state, session.assignment, session.student), ("accepted", self.exam, self.room.anna), session.reason)
        self.assertEqual(ExamStart.objects.get().session, session)
        self.assertEqual(self.start(self.room.anna).status_code, 403)

    def test_a_start_gives_one_seed_to_one_student_at_one_bench(self):
        self.assertEqual(self.start(self.room.anna).json(), self.start(self.room.anna).json())
        self.assertNotEqual(self.start(self.room.anna).json()["seed"], self.start(self.room.ben).json()["seed"])
        _, token = views.new_bench(self.room.school, "bench 2")
        self.assertEqual(self.start(self.room.anna, token).status_code, 403)
        self.assertEqual(self.start(self.room.carl).status_code, 403)
        self.exam.due = timezone.now() - timedelta(seconds=1)
        self.exam.save()
        self.assertEqual(self.start(self.room.anna).status_code, 403)

    def test_only_the_exams_bench_announces_it_and_only_forward(self):
        seed, (_, other) = self.start(self.room.anna).json()["seed"], views.new_bench(self.room.school, "bench 2")
        for seconds, token, status in ((12, None, 200), (30, other, 403), (3, None, 200), ("nan", None, 400), (-1, None, 400), ("", None, 400)):
            self.assertEqual(self.announce(seed, seconds, token).status_code, status)
        self.assertEqual([self.announce(unknown, 1).status_code for unknown in ("", "0" * 32)], [403, 403])
        self.assertEqual(ExamStart.objects.get().announced_s, 12)

    def test_a_signed_session_counts_only_for_its_student_bench_time_and_first_try(self):
        file = self.record(self.room.anna, 3)
        again = shutil.copy(file, self.folder / "again.h5")

        def reason(name, change=lambda f: None, bench=self.room.bench):
            other = pathlib.Path(shutil.copy(file, self.folder / name))
            with h5py.File(other, "a") as f:
                f.attrs.create("date", name.encode(), dtype=h5py.string_dtype("utf-8", len(name)))  # other bytes, the same hand
                change(f)
            own, self.room.bench = self.room.bench, bench
            session = self.room.judged(other, self.sign(other))
            self.room.bench = own
            self.assertEqual((session.state, session.assignment, session.points), ("refused", None, None))
            return session.reason

        self.assertIn("another student", reason("student.h5", lambda f: f.attrs.create("trainee", b"ben", dtype=h5py.string_dtype("utf-8", 3))))
        self.assertIn("another bench", reason("bench.h5", bench=views.new_bench(self.room.school, "bench 2")[0]))
        Assignment.objects.update(due=timezone.now() - timedelta(seconds=1))
        self.assertIn("after the exam's end", reason("late.h5"))
        Assignment.objects.update(due=timezone.now() + timedelta(hours=1))
        self.assertEqual(self.room.judged(again, self.sign(again)).assignment, self.exam)
        self.assertIn("earlier session", reason("twice.h5"))
        Session.objects.update(force_hash="")  # another hand
        self.assertIn("second session", reason("second.h5"))

    def test_practice_is_no_exam(self):
        session = self.room.judged(record("anna", "anna"))
        self.assertEqual((session.state, session.assignment), ("accepted", None))

    def test_another_bench_that_sends_a_copy_first_costs_nobody_the_mark(self):
        file, (other, _) = self.record(self.room.anna, 4), views.new_bench(self.room.school, "bench 2")
        own, self.room.bench = self.room.bench, other
        self.assertIn("without the bench's signature", self.room.judged(file).reason)
        self.room.bench = own
        self.assertEqual(self.room.judged(file, self.sign(file)).assignment, self.exam)

    def test_no_forged_session_gets_a_mark(self):
        """At random places of a recording. "Signed" forgeries are signed by the exam's own bench; TYPODONT_STRESS=50 makes 1,050."""
        dice, room = random.Random(68), self.room
        own, other = self.record(room.anna, 1), self.record(room.ben, 2)
        signatures = {file: self.sign(file) for file in (own, other)}
        practice, unknown = record("hand5", "anna", 5), record("hand6", "anna", 6)
        self.assertEqual(room.judged(practice).state, "accepted")
        elsewhere, _ = views.new_bench(room.school, "bench 2")
        scene = self.start(room.anna).json()["scene"]
        easier = {**scene, "task": {**scene["task"], "rules": [{**rule, "tolerance": 1000} for rule in scene["task"]["rules"]]}}

        def flip(file):
            with open(file, "r+b") as f:
                f.seek(dice.randrange(file.stat().st_size))
                byte = f.read(1)[0]
                f.seek(-1, 1)
                f.write(bytes([byte ^ 1 << dice.randrange(8)]))

        def edit(names):
            def change(file):
                with h5py.File(file, "a") as f:
                    column = f["ticks/" + dice.choice(names)]
                    column[dice.randrange(len(column))] += dice.uniform(0.01, 1)
            return change

        def shorten(after_cuts):
            """All columns end after the same tick. After the last cut, a replay cannot know how long the hand waited."""
            def change(file):
                with h5py.File(file, "a") as f:
                    index, cut = f["ticks/index"][:], f["cuts/tick"][:]
                    last = int((index <= cut[-1]).sum())
                    ticks = dice.randrange(last + 1, len(index) - 12) if after_cuts else dice.randrange(200, last)
                    for table, rows in (("ticks", ticks), ("cuts", int((cut <= index[ticks - 1]).sum()))):
                        for name in f[table]:
                            f[table][name].resize(rows, 0)
            return change

        def time_lapse(file):
            with h5py.File(file, "a") as f:
                for name in ("ticks/t_s", "ticks/t_ns", "cuts/t_ns"):
                    f[name][:] = f[name][:] * dice.uniform(0.3, 0.9)

        def text(name, value):
            def change(file):
                with h5py.File(file, "a") as f:
                    f.attrs.create(name, value.encode(), dtype=h5py.string_dtype("utf-8", len(value)))
            return change

        def with_scene(scene, of=None):
            def change(file):
                if of:
                    shutil.copy(of, file)
                with h5py.File(file, "a") as f:
                    del f["header/scene"]
                    data = json.dumps(scene).encode()
                    f.create_dataset("header/scene", data=data, dtype=h5py.string_dtype("utf-8", len(data)))
            return change

        column = ("force_x_N", "force_z_N", "depth_mm", "contact_area_mm2", "spindle_krpm")
        nothing = lambda file: None
        SIGNED, ELSEWHERE = "signed by the bench", "signed with another key"
        differs, unsigned = "replay differs", "no valid signature"
        kinds = {  # kind: change, signature, reason, circumstances
            "flipped byte": (flip, signatures[own], "", {}),
            "truncated": (lambda file: os.truncate(file, dice.randrange(1, file.stat().st_size)), signatures[own], "", {}),
            "edited tick": (edit(column), signatures[own], unsigned, {}),
            "edited tick, signed": (edit(column), SIGNED, differs, {}),
            "edited hand, signed": (edit(("hand_x_m", "hand_z_m")), SIGNED, "", {}),
            "without the last cuts, signed": (shorten(False), SIGNED, differs, {}),
            "without the end after the last cut, signed": (shorten(True), SIGNED, "shorter than its bench announced", {}),
            "faster clock, signed": (time_lapse, SIGNED, "", {}),
            "another trainee": (text("trainee", "ben"), signatures[own], unsigned, {}),
            "another trainee, signed": (text("trainee", "ben"), SIGNED, "of another student", {}),
            "easier rules, signed": (with_scene(easier), SIGNED, "another exercise", {}),
            "with warnings, signed": (with_scene({**scene, "warnings": True}), SIGNED, "an exam with warnings", {}),
            "the seed in a recording": (with_scene(scene, unknown), signatures[own], unsigned, {}),
            "the seed in an accepted session, signed": (with_scene(scene, practice), SIGNED, "an earlier session", {}),
            "the seed in a recording from before the exam, signed": (with_scene(scene, unknown), SIGNED, "longer than", {"started": timezone.now}),
            "another student's seed, signed": (with_scene(self.start(room.ben).json()["scene"]), SIGNED, "of another student", {}),
            "no signature": (nothing, "", "without the bench's signature", {}),
            "another signature": (nothing, signatures[other], unsigned, {}),
            "another key": (nothing, ELSEWHERE, unsigned, {}),
            "from another bench": (nothing, SIGNED, "from another bench", {"bench": elsewhere}),
            "after the end": (text("note", "late"), SIGNED, "after the exam's end", {"due": lambda: timezone.now() - timedelta(seconds=1)}),
            "second session": (text("note", "second"), SIGNED, "a second session", {"session": lambda: room.judged(practice)}),
        }
        found, accepted = Counter(), []
        for number in range(int(len(kinds) * STRESS)):
            kind = list(kinds)[number % len(kinds)]
            change, signature, reason, more = kinds[kind]
            file = pathlib.Path(shutil.copy(own, self.folder / f"forged{number}.h5"))
            change(file)
            with open(file, "ab") as f:  # HDF5 ignores what follows the end; the same bytes would be the same session
                f.write(number.to_bytes(2, "little"))
            if signature in (SIGNED, ELSEWHERE):
                signature = self.sign(file, os.urandom(32).hex() if signature == ELSEWHERE else more.get("bench", room.bench).signing_key)
            start = ExamStart.objects.filter(student=room.anna)
            before, due = start.get(), self.exam.due
            start.update(**{key: more[key]() for key in ("started", "session") if key in more})
            Assignment.objects.filter(pk=self.exam.pk).update(due=more["due"]() if "due" in more else due)
            bench, room.bench = room.bench, more.get("bench", room.bench)
            session = room.judged(file, signature)
            room.bench = bench
            start.update(started=before.started, session=before.session)
            Assignment.objects.filter(pk=self.exam.pk).update(due=due)
            if (session.state, session.points, session.assignment) == ("refused", None, None) and reason in session.reason:
                found[kind] += 1
            else:
                accepted.append(f"{kind} {number}: {session.state}, {session.points} points {session.reason}")
            file.unlink()
        print("forged sessions found:", "; ".join(f"{kind} {found[kind]}" for kind in kinds))
        self.assertEqual(accepted, [])
        self.assertFalse(ExamStart.objects.exclude(session=None).exists())
        for file in (own, other):
            self.assertEqual(room.judged(file, signatures[file]).state, "accepted")

    def test_every_honest_session_gets_its_mark(self):
        for number in range(int(4 * STRESS)):
            student = Student.objects.create(pseudonym=f"honest{number}")
            student.classes.add(self.room.class_A)
            file = self.record(student, number)
            session = self.room.judged(file, self.sign(file))
            self.assertEqual((session.state, session.assignment), ("accepted", self.exam), session.reason)
