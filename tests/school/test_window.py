"""The operator's window of a bench, worked by keyboard on a desktop in memory, against the service."""
import json
import os
import pathlib
import random
import subprocess
import tempfile
import threading
import time
from datetime import timedelta

from django.test import LiveServerTestCase, TestCase
from django.utils import timezone

from room import PASSWORD, Room, path_of_hand, record
from typodont_school import hand_in, intake
from typodont_school.models import Assignment, ExamStart, Session

PICTURES = os.environ.get("TYPODONT_PICTURES")
PATIENCE = 180  # s; a busy machine draws slowly


class Texts(TestCase):
    def test_every_error_has_a_sentence_in_three_languages(self):
        texts = json.loads((intake.settings.TREE / "engine/session/texts/operator.json").read_text())
        for code in (*hand_in.ERRORS, "away", "later", "failed", "no_python"):
            self.assertEqual(len(set(texts["op.school_error." + code])), 3, code)


class Window(LiveServerTestCase):
    def setUp(self):
        self.room = Room()
        self.home = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (self.home / "settings.json").write_text('{"language": "en", "scene": "", "hand": "mouse:"}')
        (self.home / "hand.csv").write_text(path_of_hand(3) + "1.2,6.85,4.6,22,1,0,0,0,0\n")
        display = f":{random.randrange(100, 50000)}"
        ready, ends = os.pipe()
        desktop = subprocess.Popen(["Xvfb", display, "-screen", "0", "1280x800x24", "-displayfd", str(ends), "-nolisten", "tcp", "-noreset", "-r"],
                                   pass_fds=[ends], stderr=subprocess.DEVNULL)
        self.addCleanup(self.end, desktop)
        os.close(ends)
        with os.fdopen(ready) as answer:
            display = ":" + answer.readline().strip()
        self.environment = {**os.environ, "DISPLAY": display, "TYPODONT_HOME": str(self.home), "LC_ALL": "C"}
        self.environment.pop("WAYLAND_DISPLAY", None)

    @staticmethod
    def end(process):
        process.kill()
        process.wait()

    def join_school(self, address=None):
        (self.home / "school.token").write_text(self.room.token)
        (self.home / "school.env").write_text(f"TYPODONT_SCHOOL_ADDRESS={address or self.live_server_url}\n")

    def open(self, **environment):
        with open(self.home / "said.txt", "a") as said:
            program = subprocess.Popen([intake.settings.PROGRAM], env={**self.environment, **environment}, stderr=said, stdout=subprocess.DEVNULL)
        self.addCleanup(self.end, program)
        self.until(lambda: self.tool("search", "--name", "^Typodont$"))
        self.tool("search", "--name", "Typodont", "windowfocus")
        time.sleep(2)
        return program

    def tool(self, *words):
        return subprocess.run(["xdotool", *words], env=self.environment, capture_output=True, text=True).stdout

    def press(self, *keys):
        for key in keys:
            self.tool("key", "--delay", "60", key)
            time.sleep(0.4)

    def type(self, text):
        self.tool("type", "--delay", "30", text)
        time.sleep(0.4)

    def until(self, condition):
        end = time.monotonic() + PATIENCE
        while not condition():
            self.assertLess(time.monotonic(), end, self.said())
            time.sleep(0.2)

    def said(self):
        file = self.home / "said.txt"
        return file.read_text() if file.exists() else ""

    def hear(self, words):
        self.until(lambda: words in self.said())

    def sign_in(self, password=PASSWORD):
        self.press("ctrl+i")
        self.until(lambda: self.tool("search", "--name", ": School$"))
        self.type("anna")
        self.press("Tab")
        self.type(password)
        self.press("Return")

    def picture(self, name):
        if PICTURES:
            time.sleep(3)
            subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "x11grab", "-video_size", "1280x800", "-i", self.environment["DISPLAY"], "-frames:v", "1",
                            pathlib.Path(PICTURES) / (name + ".png")], check=True)

    def checks(self):
        """Checks what was handed in, as the service does."""
        over = threading.Event()
        thread = threading.Thread(target=lambda: [intake.process_waiting() for _ in iter(lambda: over.wait(0.5), True)])
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(over.set)

    def drill(self):
        self.press("ctrl+h")
        self.type(f"script:{self.home / 'hand.csv'}")
        self.press("F5")
        self.hear("session ended")

    def test_a_student_signs_in_takes_the_next_exercise_and_hands_it_in_by_keyboard(self):
        for attempt, points in enumerate((41, 58, 63, 74)):
            self.room.judged(record(f"hand{attempt}", "anna", attempt))
            Session.objects.filter(attempt=attempt + 1).update(points=points)
        Assignment.objects.create(group=self.room.class_A, exercise=self.room.exercise, due=timezone.now() + timedelta(days=3))
        Assignment.objects.create(group=self.room.class_A, exercise=self.room.exercise, due=timezone.now() + timedelta(days=5), attempts=1, sealed=True)
        self.join_school()
        self.checks()
        program = self.open()
        self.sign_in()
        self.hear("open assignments: 2")
        self.picture("window")
        self.press("ctrl+i")
        self.hear("exercise selected: ")
        self.picture("window-start")
        self.assertIn("class-1-cavity.json", self.said())
        self.drill()
        self.hear("handed in: accepted")
        self.picture("window-result")
        session = Session.objects.get(attempt=5)
        self.assertEqual((session.student, session.exercise, session.state), (self.room.anna, self.room.exercise, "accepted"))
        self.press("ctrl+q")
        self.assertEqual(program.wait(PATIENCE), 0)
        self.assertEqual(json.loads((self.home / "settings.json").read_text())["trainee"], "")  # the next person is nobody yet
        self.assertNotIn(PASSWORD, self.said())

    def test_an_exam_is_announced_while_it_runs_and_at_its_end_and_counts(self):
        exam = Assignment.objects.create(group=self.room.class_A, exercise=self.room.exercise, due=timezone.now() + timedelta(days=5), attempts=1, sealed=True)
        (self.home / "key").touch(mode=0o600)
        (self.home / "key").write_text(self.room.bench.signing_key + "\n")
        (self.home / "hand.csv").write_text(path_of_hand(3) + "300,6.85,4.6,22,1,0,0,0,0\n")
        self.join_school()
        with open(self.home / "school.env", "a") as settings:
            settings.write(f"TYPODONT_SCHOOL_KEY_FILE={self.home / 'key'}\n")
        self.checks()
        self.open()
        self.sign_in()
        self.hear("open assignments: 1")
        self.press("ctrl+i")
        self.hear(f"exam-{exam.pk}.json")
        self.press("ctrl+h")
        self.type(f"script:{self.home / 'hand.csv'}")
        self.press("F5")
        self.until(lambda: ExamStart.objects.get().announced_s >= 10)
        self.press("F10")
        self.hear("handed in: accepted")
        session = Session.objects.get()
        self.assertEqual((session.assignment, session.points is None), (exam, False))
        self.assertAlmostEqual(ExamStart.objects.get().announced_s, session.seconds, delta=0.01)

    def test_a_session_without_the_server_is_sent_at_the_next_start(self):
        self.join_school()
        program = self.open()
        self.sign_in()
        self.hear("signed in at the school")
        self.hear("open assignments: 0")
        self.press("F10")
        (self.home / "school.env").write_text("TYPODONT_SCHOOL_ADDRESS=http://127.0.0.1:9\n")
        self.drill()
        self.hear("school: later")
        self.picture("window-later")
        self.press("ctrl+q")
        self.assertEqual(program.wait(PATIENCE), 0)
        self.assertEqual(Session.objects.count(), 0)
        self.join_school()
        self.open()
        self.hear("handed in: 1 of an earlier time")
        self.assertEqual(Session.objects.count(), 1)

    def test_a_session_that_ends_with_the_window_is_handed_in_at_the_next_start(self):
        self.join_school()
        (self.home / "hand.csv").write_text(path_of_hand(3) + "300,6.85,4.6,22,1,0,0,0,0\n")
        program = self.open()
        self.sign_in()
        self.hear("open assignments: 0")
        self.press("F10", "ctrl+h")
        self.type(f"script:{self.home / 'hand.csv'}")
        self.press("F5")
        self.hear("session started")
        time.sleep(2)
        program.terminate()
        self.assertEqual(program.wait(PATIENCE), 0)
        self.assertEqual(Session.objects.count(), 0)
        self.open()
        self.hear("handed in: 1 of an earlier time")
        self.assertEqual(Session.objects.count(), 1)

    def test_a_wrong_password_and_a_server_that_is_away_are_said(self):
        self.join_school()
        self.open()
        self.sign_in("guess")
        self.hear("school: wrong")
        self.join_school("http://127.0.0.1:9")
        self.press("Tab", "Tab")
        self.type("guess")
        self.press("Return")
        self.hear("school: away")

    def test_without_python_the_window_says_so(self):
        self.join_school()
        self.open(PATH="/nonexistent")
        self.sign_in("guess")
        self.hear("school: no_python")

    def test_without_a_benchs_token_the_window_never_asks(self):
        asked = self.home / "bin" / "python3"
        asked.parent.mkdir()
        asked.write_text(f"#!/bin/sh\ntouch {self.home}/asked\n")
        asked.chmod(0o755)
        (self.home / "sessions").mkdir()
        (self.home / "sessions/.handed-in.json").write_text("{}")
        program = self.open(PATH=f"{asked.parent}:{os.environ['PATH']}")
        self.press("ctrl+i")
        self.assertFalse(self.tool("search", "--name", ": School$"))
        self.drill()
        self.press("ctrl+q")
        self.assertEqual(program.wait(PATIENCE), 0)
        self.assertFalse((self.home / "asked").exists())
