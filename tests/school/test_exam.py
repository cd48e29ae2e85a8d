"""Sealed exams: a forged session never gets a mark, an honest one always does."""
import json
import os
import pathlib
import random
import shutil
import subprocess
import tempfile
from datetime import timedelta

import h5py
from django.conf import settings
from django.test import TestCase
from django.utils import timezone

from room import Room, record
from typodont_school import intake, views
from typodont_school.models import Assignment, ExamStart, Session, Student

STRESS = float(os.environ.get("TYPODONT_STRESS", 1))


class Exams(TestCase):
    def setUp(self):
        shutil.rmtree(intake.folder("sessions"))
        self.room = Room()
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.exam = Assignment.objects.create(group=self.room.class_A, exercise=self.room.exercise, due=timezone.now() + timedelta(hours=1),
                                              attempts=1, sealed=True)

    def start(self, student, token=None):
        return self.client.post(f"/api/exam/{self.exam.pk}", {"student": student.pseudonym}, HTTP_AUTHORIZATION="Bearer " + (token or self.room.token))

    def record(self, student, seed):
        """What the bench records: the exam's scene with its seed."""
        scene = self.folder / student.pseudonym / "class-1-cavity.json"
        scene.parent.mkdir(exist_ok=True)
        scene.write_text(json.dumps(self.start(student).json()["scene"]))
        return shutil.copy(record(f"exam-{student.pseudonym}-{os.urandom(4).hex()}", student.pseudonym, seed, scene), self.folder)

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

    def test_no_forged_session_gets_a_mark(self):
        """Edited, truncated, swapped, replayed, unsigned and wrongly signed sessions, at random places."""
        dice = random.Random(68)
        own, other = self.record(self.room.anna, 1), self.record(self.room.ben, 2)
        signatures = {own: self.sign(own), other: self.sign(other)}
        practice = record("hand5", "anna", 5)

        def forge(kind, number):
            file = pathlib.Path(shutil.copy(own, self.folder / f"forged{number}.h5"))
            if kind == "flipped byte":
                with open(file, "r+b") as f:
                    f.seek(dice.randrange(file.stat().st_size))
                    byte = f.read(1)[0]
                    f.seek(-1, 1)
                    f.write(bytes([byte ^ 1 << dice.randrange(8)]))
            elif kind == "truncated":
                os.truncate(file, dice.randrange(1, file.stat().st_size))
            elif kind in ("edited", "edited by the bench"):
                with h5py.File(file, "a") as f:
                    name = dice.choice(("force_x_N", "force_z_N", "depth_mm", "contact_area_mm2", "spindle_krpm"))
                    column = f["ticks/" + name]
                    column[dice.randrange(len(column))] += dice.choice((-1, 1)) * dice.uniform(0.01, 1)
            elif kind == "another trainee":
                with h5py.File(file, "a") as f:
                    f.attrs.create("trainee", b"ben", dtype=h5py.string_dtype("utf-8", 3))
            elif kind == "the seed in another recording":
                shutil.copy(practice, file)
                scene = self.start(self.room.anna).json()["scene"]
                with h5py.File(file, "a") as f:
                    del f["header/scene"]
                    f.create_dataset("header/scene", data=json.dumps(scene), dtype=h5py.string_dtype("utf-8"))
            signature = {"no signature": "", "swapped signature": signatures[other], "signed elsewhere": None, "edited by the bench": None}.get(kind, signatures[own])
            if signature is None:
                signature = self.sign(file, None if kind == "edited by the bench" else os.urandom(32).hex())
            with open(file, "ab") as f:  # HDF5 ignores what follows the end; the same bytes would be the same session
                f.write(b"" if kind in ("edited by the bench", "signed elsewhere") else bytes([number % 256, number // 256]))
            return file, signature

        kinds = ("flipped byte", "truncated", "edited", "edited by the bench", "another trainee", "the seed in another recording", "no signature",
                 "swapped signature", "signed elsewhere")
        for number in range(int(18 * STRESS)):
            kind = kinds[number % len(kinds)]
            file, signature = forge(kind, number)
            session = self.room.judged(file, signature)
            self.assertEqual((session.state, session.points, session.assignment), ("refused", None, None), f"{kind} {number}")
            file.unlink()
        self.assertFalse(ExamStart.objects.exclude(session=None).exists())
        for file in (own, other):
            self.assertEqual(self.room.judged(file, signatures[file]).state, "accepted")

    def test_every_honest_session_gets_its_mark(self):
        for number in range(int(4 * STRESS)):
            student = Student.objects.create(pseudonym=f"honest{number}")
            student.classes.add(self.room.class_A)
            file = self.record(student, number)
            session = self.room.judged(file, self.sign(file))
            self.assertEqual((session.state, session.assignment), ("accepted", self.exam), session.reason)
