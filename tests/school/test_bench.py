"""What the operator's window asks through hand_in.py: sign-in, own scores, next exercise, hand-in."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
from datetime import timedelta
from unittest import mock

from django.core import signing
from django.test import LiveServerTestCase
from django.utils import timezone

from room import PASSWORD, Room, record, sha256
from typodont_school import intake, interface, program, views
from typodont_school.models import Assignment, ExamStart, Exercise, Session, SignInFailure

SCRIPT = intake.settings.HERE / "hand_in.py"


class Window(LiveServerTestCase):
    def setUp(self):
        self.room = Room()
        self.home = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.sessions, self.scenes = self.home / "sessions", self.home / "scenes"
        (self.sessions / "anna").mkdir(parents=True)
        (self.home / "school.token").write_text(self.room.token)
        self.at(self.live_server_url)
        self.environment = {"PATH": os.environ["PATH"], "TYPODONT_HOME": str(self.home)}

    def at(self, address):
        (self.home / "school.env").write_text(f"TYPODONT_SCHOOL_ADDRESS={address}\n")

    def ask(self, do, **asked):
        """Returns the rows that the program prints."""
        asked = {"do": do, "language": "en", "program": intake.settings.PROGRAM, "folder": str(self.sessions), **asked}
        done = subprocess.run([sys.executable, SCRIPT, "window"], input=json.dumps(asked), env=self.environment, check=True, capture_output=True, text=True)
        self.assertEqual(done.stderr, "")
        return [json.loads(line) for line in done.stdout.splitlines()]

    def sign_in(self, name="anna", password=PASSWORD):
        return self.ask("sign_in", name=name, password=password)[-1]

    def assign(self, exercise=None, **more):
        more = {"due": timezone.now() + timedelta(days=3), "attempts": 2, **more}
        return Assignment.objects.create(group=self.room.class_A, exercise=exercise or self.room.exercise, **more)

    def add(self, name, *arguments):
        return pathlib.Path(shutil.copy(record(name, *arguments), self.sessions / "anna" / (name + ".h5")))

    def test_a_student_sees_own_scores_and_open_assignments_soonest_first(self):
        self.room.judged(record("anna", "anna"))
        self.room.judged(record("hand2", "anna", 2))
        self.room.judged(record("ben", "ben", 1))
        later, exam = self.assign(attempts=3), self.assign(sealed=True, due=timezone.now() + timedelta(hours=2))
        self.assign(due=timezone.now() - timedelta(hours=1))
        Assignment.objects.create(group=self.room.class_B, exercise=self.room.exercise, due=timezone.now() + timedelta(days=1))
        Session.objects.filter(student=self.room.anna, attempt=1).update(assignment=later)
        signed = self.sign_in()
        self.assertEqual(signed["student"], "anna")
        shown = self.ask("me", token=signed["token"], language="de")[-1]
        self.assertEqual([curve["points"] for curve in shown["curves"]],
                         [[round(points, 1) for points in Session.objects.filter(student=self.room.anna).order_by("attempt").values_list("points", flat=True)]])
        self.assertEqual(shown["curves"][0]["title"], self.room.exercise.title("de"))
        self.assertEqual([(row["number"], row["left"], row["sealed"]) for row in shown["assignments"]], [(exam.pk, 1, True), (later.pk, 2, False)])

    def test_wrong_passwords_teachers_and_locked_accounts_get_no_token(self):
        self.assertEqual(self.sign_in(password="guess"), {"error": "wrong"})
        self.assertEqual(self.sign_in("nobody", "guess"), {"error": "wrong"})
        self.assertEqual(self.sign_in("teacherA"), {"error": "no_student"})
        for _ in range(8):
            self.client.post("/sign-in", {"username": "anna", "password": "guess"})
        self.assertEqual(self.sign_in(), {"error": "too_many"})
        SignInFailure.objects.all().delete()  # as 15 minutes later
        self.assertIn("token", self.sign_in())

    def test_a_token_ends_with_time_password_account_and_bench(self):
        token = self.sign_in()["token"]
        self.assertIn("curves", self.ask("me", token=token)[-1])
        for bad in ("", "guess", token[:-1], interface.token_of(self.room.ben, self.room.bench)[:-2], signing.dumps([1, 2, "x"])):
            self.assertEqual(self.ask("me", token=bad)[-1], {"error": "expired"})
        with mock.patch.object(interface, "TOKEN_AGE", timedelta(seconds=-1)):
            self.assertEqual(self.ask("me", token=token)[-1], {"error": "expired"})
        bench, bench_token = views.new_bench(self.room.school, "bench 2")
        (self.home / "school.token").write_text(bench_token)
        self.assertEqual(self.ask("me", token=token)[-1], {"error": "expired"})
        (self.home / "school.token").write_text("guess")
        self.assertEqual(self.sign_in(), {"error": "no_bench"})
        (self.home / "school.token").write_text(self.room.token)
        anna = self.room.anna.user
        anna.is_active = False
        anna.save()
        self.assertEqual(self.ask("me", token=token)[-1], {"error": "expired"})
        anna.is_active = True
        anna.set_password("another horse battery")
        anna.save()
        self.assertEqual(self.ask("me", token=token)[-1], {"error": "expired"})

    def test_no_address_answers_without_a_benchs_token(self):
        for address in ("/api/me", "/api/sign-in", f"/api/assignment/{self.assign().pk}/files.zip"):
            for method in (self.client.get, self.client.post):
                self.assertEqual(method(address, {"name": "anna", "password": PASSWORD}).status_code, 401)

    def test_files_of_others_are_refused_like_absent_ones(self):
        mine, token = self.assign(), self.sign_in("carl")["token"]
        headers = {"HTTP_AUTHORIZATION": "Bearer " + self.room.token, "HTTP_X_STUDENT": token}
        there, absent = (self.client.get(f"/api/assignment/{key}/files.zip", **headers) for key in (mine.pk, 99999))
        self.assertEqual((there.status_code, absent.status_code, there.content), (403, 403, absent.content))

    def test_an_assigned_case_is_put_into_the_folder_of_scenes_and_scores(self):
        self.client.login(username="teacherA", password=PASSWORD)
        self.client.post(f"/class/{self.room.class_A.pk}/case", {"family": program.families()[0], "seed": 3, "difficulty": 50})
        case = Exercise.objects.get(name__startswith=program.families()[0] + "-3-")
        self.assign(case)
        signed = self.sign_in()
        row = self.ask("me", token=signed["token"])[-1]["assignments"][0]
        taken = self.ask("take", folder=str(self.scenes), **signed, **row)[-1]
        self.assertEqual(taken, {"scene": str(self.scenes / (case.name + ".json"))})
        self.assertEqual(sorted(f.name for f in self.scenes.iterdir()), [case.name + ".json", case.name + ".vdb"])
        session = self.room.judged(record("case", "anna", 0, taken["scene"]))
        self.assertEqual((session.state, session.exercise), ("accepted", case), session.reason)

    def test_an_exam_begins_with_its_download_and_counts(self):
        exam, signed = self.assign(sealed=True, attempts=1), self.sign_in()
        (self.home / "key").touch(mode=0o600)
        (self.home / "key").write_text(self.room.bench.signing_key + "\n")
        self.environment["TYPODONT_SCHOOL_KEY_FILE"] = str(self.home / "key")
        headers = {"HTTP_AUTHORIZATION": "Bearer " + self.room.token, "HTTP_X_STUDENT": signed["token"]}
        self.assertEqual(self.client.get(f"/api/assignment/{exam.pk}/files.zip", **headers).status_code, 403)  # not begun
        asked = {"folder": str(self.scenes), "number": exam.pk, "sealed": True, **signed}
        scene = self.ask("take", **asked)[-1]["scene"]
        self.assertEqual(pathlib.Path(scene).name, f"exam-{exam.pk}.json")
        file = self.add("exam", "anna", 0, scene)
        ExamStart.objects.update(started=timezone.now() - timedelta(minutes=1))  # the program's hand works faster than real time
        self.hand_in_checked(file)
        self.assertEqual(Session.objects.get().assignment, exam)
        self.assertEqual(self.ask("take", **asked)[-1], {"error": "not_open"})

    def want(self, file):
        """What the window leaves beside a recording."""
        file.with_name(file.name + ".to-hand-in").touch()
        return file

    def hand_in_checked(self, file):
        checks, done = threading.Event(), threading.Thread(target=lambda: [intake.process_waiting() for _ in iter(lambda: checks.wait(0.5), True)])
        done.start()
        try:
            rows = self.ask("hand_in", file=str(file))
        finally:
            checks.set()
            done.join()
        self.assertEqual(rows, [{"stage": "sending"}, {"stage": "checking"}, {"state": "accepted"}])

    def test_a_session_is_handed_in_and_its_state_is_said(self):
        file = self.want(self.add("anna", "anna"))
        self.hand_in_checked(file)
        self.assertEqual(Session.objects.get().pk, sha256(file))
        self.assertEqual(list(self.sessions.rglob("*.to-hand-in")), [])

    def test_without_the_service_the_next_window_sends_what_waits_and_nothing_else(self):
        self.at("http://127.0.0.1:9")
        self.assertEqual(self.sign_in(), {"error": "away"})
        wanted = self.want(self.add("anna", "anna"))
        self.want(self.sessions / "anna/deleted.h5")
        self.add("ben", "ben", 1)  # a guest's, for which the window was not asked
        self.assertEqual(self.ask("hand_in", file=str(wanted)), [{"stage": "sending"}, {"error": "later"}])
        self.assertEqual(self.ask("send_wanted")[-1], {"sent": 0, "left": 1})
        self.at(self.live_server_url)
        self.assertEqual([self.ask("send_wanted")[-1] for _ in range(2)], [{"sent": 1, "left": 0}, {"sent": 0, "left": 0}])
        self.assertEqual([s.pk for s in Session.objects.all()], [sha256(wanted)])
        self.assertEqual(list(self.sessions.rglob("*.to-hand-in")), [])

    def test_what_the_window_could_not_send_is_sent_by_the_watch(self):
        self.at("http://127.0.0.1:9")
        self.ask("hand_in", file=str(self.want(self.add("anna", "anna"))))
        self.at(self.live_server_url)
        subprocess.run([sys.executable, SCRIPT, self.sessions, "once"], env=self.environment, check=True, capture_output=True)
        self.assertEqual((Session.objects.count(), self.ask("send_wanted")[-1]), (1, {"sent": 0, "left": 0}))

    def test_a_password_stays_in_memory(self):
        secret = "battery staple correct"
        anna = self.room.anna.user
        anna.set_password(secret)
        anna.save()
        signed = self.sign_in(password=secret)
        self.ask("me", token=signed["token"])
        for file in self.home.rglob("*"):
            if file.is_file():
                self.assertNotIn(secret.encode(), file.read_bytes())
                self.assertNotIn(signed["token"].encode(), file.read_bytes())
