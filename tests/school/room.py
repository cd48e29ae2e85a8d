"""A school with two classes, and recordings by the program's scripted hands."""
import hashlib
import pathlib
import shutil
import subprocess
import tempfile

import h5py
from django.conf import settings
from django.contrib.auth.models import User

from typodont_school import intake, views
from typodont_school.__main__ import register_exercises
from typodont_school.models import Class, Exercise, School, Session, Student

_folder = tempfile.TemporaryDirectory(prefix="typodont_school_recordings_")
PASSWORD = "correct horse battery"


def path_of_hand(seed):
    """A hand that drills one groove for 0.7 s; each seed another groove."""
    y = 4.2 + 0.13 * (seed % 20)
    rows = [(0, y, 21.6, 0), (0.1, y, 20.9, 1), (0.35, y, 20.2 - 0.01 * (seed // 20), 1), (0.6, y + 0.6, 20.1, 1), (0.7, y, 22, 0)]
    return "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n" + "".join(f"{t},6.85,{a:.3f},{z:.3f},1,0,0,0,{p}\n" for t, a, z, p in rows)


def record(name, trainee, seed=0, scene="class-1-cavity", date="2026-01-01T10:00:00Z"):
    """Returns a recording of a trainee, made once a name."""
    out = pathlib.Path(_folder.name) / (name + ".h5")
    if not out.exists():
        hand = out.with_suffix(".csv")
        hand.write_text(path_of_hand(seed))
        subprocess.run([settings.PROGRAM, "servo", str(scene), "--hand", f"script:{hand}", "--out", str(out), "--no-timing"], check=True, capture_output=True)
        with h5py.File(out, "a") as f:
            for name, text in (("trainee", trainee), ("date", date)):
                f.attrs.create(name, text.encode(), dtype=h5py.string_dtype("utf-8", len(text.encode()) or 1))
    return out


def sha256(file):
    return hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()


def user(name, **more):
    return User.objects.create_user(name, password=PASSWORD, **more)


class Room:
    """Class A with anna and ben, class B with carl; one teacher each, an administrator, a bench; no recordings."""
    def __init__(self):
        for name in ("incoming", "sessions", "derived"):
            shutil.rmtree(intake.folder(name))
        register_exercises(settings.SCENES)
        self.school = School.objects.create(name="School")
        self.admin = User.objects.create_superuser("root", password=PASSWORD)
        self.exercise = Exercise.objects.get(name="class-1-cavity")
        self.bench, self.token = views.new_bench(self.school, "bench 1")
        for letter, names in (("A", ("anna", "ben")), ("B", ("carl",))):
            group = Class.objects.create(school=self.school, name="Class " + letter, source_id="class-" + letter)
            teacher = user("teacher" + letter, is_staff=True)
            group.teachers.add(teacher)
            setattr(self, "class_" + letter, group)
            setattr(self, "teacher_" + letter, teacher)
            for name in names:
                student = Student.objects.create(pseudonym=name, user=user(name), source_id="id-" + name)
                student.classes.add(group)
                setattr(self, name, student)

    def put(self, file, signature=""):
        """Stores a recording as an upload would."""
        data = pathlib.Path(file).read_bytes()
        intake.append(self.bench, sha256(file), 0, len(data), data, signature)
        return Session.objects.get(pk=sha256(file))

    def judged(self, file, signature=""):
        session = self.put(file, signature)
        intake.process_waiting()
        session.refresh_from_db()
        return session
