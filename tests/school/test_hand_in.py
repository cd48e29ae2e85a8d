"""Hand-in: nothing is lost, nothing counts twice, nothing is believed."""
import errno
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import threading
from datetime import timedelta
from unittest import mock

import h5py
from django.test import LiveServerTestCase, TestCase
from django.utils import timezone

from room import Room, record, sha256
from service import ServiceTest
from typodont_school import intake, program
from typodont_school.hand_in import Folder, Later, Service
from typodont_school.models import Assignment, Session


class HandIn(LiveServerTestCase):
    def setUp(self):
        self.room = Room()
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.service = Service(self.live_server_url, self.room.token)
        self.said = []

    def add(self, name, *arguments, **more):
        return pathlib.Path(shutil.copy(record(name, *arguments, **more), self.folder / f"{name}.h5"))

    def send(self, service=None):
        return Folder(self.folder).hand_in(service or self.service, self.said.append)

    def test_a_session_arrives_is_replayed_and_scored_by_the_server(self):
        file = self.add("anna", "anna")
        self.assertEqual(self.send(), 0)
        self.assertEqual(intake.recording_of(sha256(file)).read_bytes(), file.read_bytes())
        intake.process_waiting()
        session = Session.objects.get()
        self.assertEqual((session.state, session.student, session.exercise, session.attempt), ("accepted", self.room.anna, self.room.exercise, 1))
        own = json.loads(program.typodont("report", file, "--out", self.folder / "own.html", "--json"))
        self.assertEqual(session.points, 100 * own["points"] / own["full"])
        self.assertEqual(session.items.count(), len(own["items"]))

    def test_a_server_that_is_away_loses_nothing(self):
        self.add("anna", "anna")
        self.add("ben", "ben", 1)
        away = Service("http://127.0.0.1:9", self.room.token)
        self.assertEqual([self.send(away) for _ in range(3)], [2, 2, 2])
        self.assertEqual(self.send(), 0)
        self.assertEqual(Session.objects.count(), 2)

    def test_an_upload_goes_on_where_it_was_cut(self):
        file = self.add("anna", "anna")
        sha, data = sha256(file), file.read_bytes()
        self.service.ask(sha, data[:1000], **{"Content-Range": f"bytes 0-999/{len(data)}"})
        sent = []
        with mock.patch.object(Service, "ask", autospec=True, side_effect=(
                lambda own, sha, chunk=None, _ask=Service.ask, **h: (sent.append(len(chunk or b"")), _ask(own, sha, chunk, **h))[1])):
            self.assertEqual(self.send(), 0)
        self.assertEqual(sum(sent), len(data) - 1000)

    def test_duplicates_are_one_session(self):
        file = self.add("anna", "anna")
        shutil.copy(file, self.folder / "again.h5")
        self.assertEqual((self.send(), self.send()), (0, 0))
        (self.folder / ".handed-in.json").write_text("{damaged")
        self.assertEqual(self.send(), 0)
        self.assertEqual(Session.objects.count(), 1)

    def test_a_recording_that_is_still_written_waits(self):
        file = self.add("anna", "anna")
        journal = file.with_name(file.name + ".journal")
        journal.touch()
        self.send()
        self.assertEqual(Session.objects.count(), 0)
        journal.unlink()
        self.send()
        self.assertEqual(Session.objects.count(), 1)

    def test_two_benches_at_once_send_the_same_session(self):
        file = self.add("anna", "anna")
        def one():
            for _ in range(50):
                try:
                    return self.service.send(file)
                except Later:
                    pass
        threads = [threading.Thread(target=one) for _ in range(4)]
        for t in threads: t.start()
        for t in threads: t.join()
        self.send()
        self.assertEqual(Session.objects.count(), 1)
        self.assertEqual(intake.recording_of(sha256(file)).read_bytes(), file.read_bytes())

    def test_random_faults_lose_nothing_and_count_nothing_twice(self):
        """Cut connections, full disks, killed servers, lost lists, duplicates: in any order."""
        faults = int(100 * float(os.environ.get("TYPODONT_STRESS", 1)))
        files = [self.add(f"hand{i}", "anna", i) for i in range(4)]
        dice = random.Random(68)
        real_ask = Service.ask

        def ask(own, sha, chunk=None, **headers):
            fault = dice.choice(("none", "cut before", "cut after", "short", "full", "killed"))
            if fault == "cut before":
                raise Later(fault)
            if fault == "short" and chunk:
                total = headers["Content-Range"].rpartition("/")[2]
                first = int(headers["Content-Range"].split()[1].split("-")[0])
                chunk = chunk[:max(1, len(chunk) // 3)]
                headers["Content-Range"] = f"bytes {first}-{first + len(chunk) - 1}/{total}"
            if fault == "full":
                with mock.patch.object(intake.os, "fsync", side_effect=OSError(errno.ENOSPC, "full")):
                    return real_ask(own, sha, chunk, **headers)
            if fault == "killed":  # before or after the row is written
                where = dice.choice(((intake.Session.objects, "get_or_create"), (intake, "settle")))
                with mock.patch.object(*where, side_effect=SystemError("killed")):
                    return real_ask(own, sha, chunk, **headers)
            answer = real_ask(own, sha, chunk, **headers)
            if fault == "cut after":
                raise Later(fault)
            return answer

        with mock.patch.object(Service, "ask", ask), mock.patch("typodont_school.hand_in.CHUNK", 60_000):
            for _ in range(faults // len(files)):
                if dice.random() < 0.1:
                    (self.folder / ".handed-in.json").unlink(missing_ok=True)
                self.send()
        self.send()
        intake.process_waiting()
        self.assertEqual({(s.pk, s.state) for s in Session.objects.all()}, {(sha256(f), "accepted") for f in files})
        for file in files:
            self.assertEqual(intake.recording_of(sha256(file)).read_bytes(), file.read_bytes())

    def test_a_bench_with_a_key_signs_what_it_hands_in(self):
        file = self.add("anna", "anna")
        key = self.folder / "key"
        key.touch(mode=0o600)
        for number, text in enumerate(("0" * 64, self.room.bench.signing_key)):  # the wrong key, then the right one
            key.write_text(text + "\n")
            file.with_name("anna.h5.sig").unlink(missing_ok=True)
            (self.folder / ".handed-in.json").unlink(missing_ok=True)
            with mock.patch.multiple("typodont_school.hand_in", KEY_FILE=str(key), PROGRAM=intake.settings.PROGRAM):
                self.assertEqual(self.send(), 0)
            intake.process_waiting()
            self.assertEqual(Session.objects.get().state, ("refused", "accepted")[number])

    def test_a_crash_after_the_last_byte_loses_nothing(self):
        file = self.add("anna", "anna")
        with mock.patch.object(intake.Session.objects, "get_or_create", side_effect=SystemError("killed")):
            self.assertEqual(self.send(), 1)
        self.assertEqual(self.send(), 0)
        self.assertEqual(intake.recording_of(sha256(file)).read_bytes(), file.read_bytes())

    def test_an_upload_that_another_has_overtaken_changes_nothing(self):
        """The operator's window and the watch send the same recording."""
        file = self.add("anna", "anna")
        sha, data = sha256(file), file.read_bytes()
        absent, asked = Session.objects.none(), iter((True, False))

        def overtaken(**query):  # the other upload ends after the first question
            if query == {"pk": sha} and next(asked, False):
                intake.append(self.room.bench, sha, 0, len(data), data, "")
                return absent
            return Session.objects.all().filter(**query)
        with mock.patch.object(Session.objects, "filter", side_effect=overtaken):
            intake.append(self.room.bench, sha, len(data) - 9, len(data), data[-9:], "")
        self.assertEqual(list(intake.folder("incoming").iterdir()), [])
        intake.process_waiting()
        self.assertEqual((Session.objects.get().state, intake.recording_of(sha).read_bytes() == data), ("accepted", True))

    def test_abandoned_uploads_do_not_keep_others_out(self):
        file = self.add("anna", "anna")
        old, young = (intake.folder("incoming") / (letter * 64) for letter in "ab")
        for part in (old, young):
            part.write_bytes(b"abandoned")
        os.utime(old, (1e9, 1e9))
        with mock.patch.object(intake, "MAX_INCOMPLETE", 2):
            self.assertEqual(self.send(), 0)
        self.assertEqual(list(intake.folder("incoming").iterdir()), [young])
        self.assertEqual(Session.objects.get().pk, sha256(file))

    def test_a_wrong_token_hands_in_nothing(self):
        self.add("anna", "anna")
        self.assertEqual(self.send(Service(self.live_server_url, "guess")), 1)
        self.assertEqual(list(intake.folder("incoming").iterdir()), [])

    def test_limits_of_size_and_number(self):
        status, _ = self.service.ask("a" * 64, b"x", **{"Content-Range": f"bytes 0-0/{intake.settings.MAX_SESSION_BYTES + 1}"})
        self.assertEqual(status, 413)
        for text in ("bytes 0-0", "bytes -1-0/5", "bytes 0-5/3", "lines 0-0/1", "bytes 0-1/9", ""):
            self.assertIn(self.service.ask("a" * 64, b"x", **{"Content-Range": text})[0], (400, 413), text)
        with mock.patch.object(intake, "MAX_INCOMPLETE", 0):
            self.assertEqual(self.service.ask("b" * 64, b"x", **{"Content-Range": "bytes 0-0/2"})[0], 429)
        with mock.patch.object(intake.settings, "MIN_FREE_BYTES", 1 << 60):
            self.assertEqual(self.service.ask("b" * 64, b"x", **{"Content-Range": "bytes 0-0/2"})[0], 507)
        self.assertEqual(list(intake.folder("incoming").iterdir()), [])


class Hostile(TestCase):
    def setUp(self):
        self.room = Room()
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def changed(self, change, name="changed.h5"):
        file = pathlib.Path(shutil.copy(record("anna", "anna"), self.folder / name))
        change(file)
        return self.room.judged(file)

    def refused(self, change):
        session = self.changed(change)
        self.assertEqual((session.state, session.points), ("refused", None), session.reason)
        self.assertTrue(session.reason)
        return session.reason

    def test_bytes_that_are_no_recording(self):
        self.refused(lambda f: f.write_bytes(b"<html>not a recording</html>"))
        self.refused(lambda f: f.write_bytes(os.urandom(5000)))

    def test_a_truncated_file(self):
        for share in (0.1, 0.5, 0.9):
            self.refused(lambda f: os.truncate(f, int(share * f.stat().st_size)))

    def test_an_edited_force_is_found_by_the_replay(self):
        def edit(file):
            with h5py.File(file, "a") as f:
                f["ticks/force_z_N"][300] += 0.01
        self.assertIn("replay differs", self.refused(edit))

    def test_a_link_to_a_file_of_the_server_is_not_followed(self):
        def link(file):
            with h5py.File(file, "a") as f:
                del f["header/rig"]
                f["header/rig"] = h5py.ExternalLink("/etc/passwd", "/")
        self.refused(link)

    def test_softer_rules_in_the_scene_make_it_no_exercise(self):
        scene = json.loads((intake.settings.SCENES / "class-1-cavity.json").read_text())
        for rule in scene["task"]["rules"]:
            rule["tolerance"] = 1000
        soft = self.folder / "class-1-cavity.json"
        soft.write_text(json.dumps(scene))
        session = self.room.judged(record("soft", "anna", 3, soft))
        self.assertEqual((session.state, session.exercise, session.points), ("accepted", None, None))

    def test_the_hand_of_an_earlier_session_counts_once_also_without_its_end(self):
        self.assertEqual(self.room.judged(record("anna", "anna")).state, "accepted")
        def other_name(file, ticks):
            with h5py.File(file, "a") as f:
                f.attrs.create("trainee", b"ben", dtype=h5py.string_dtype("utf-8", 3))
                for column in f["ticks"].values():
                    column.resize(ticks, 0)
        for ticks in (701, 700, 690):  # the replay of each is identical
            self.assertIn("earlier session", self.refused(lambda file: other_name(file, ticks)))

    def test_a_wrong_clock_of_the_bench_changes_no_order_and_no_deadline(self):
        late = timezone.now() - timedelta(days=1)
        Assignment.objects.create(group=self.room.class_A, exercise=self.room.exercise, opens=late - timedelta(days=9), due=late)
        past = self.room.judged(record("past", "anna", 1, date="1999-01-01T00:00:00Z"))
        future = self.room.judged(record("future", "anna", 2, date="2099-01-01T00:00:00Z"))
        self.assertEqual((past.attempt, future.attempt, past.assignment), (1, 2, None))

    def test_attempts_beyond_the_assignment_do_not_count_for_it(self):
        task = Assignment.objects.create(group=self.room.class_A, exercise=self.room.exercise, due=timezone.now() + timedelta(days=1), attempts=1)
        one, two = self.room.judged(record("hand1", "anna", 1)), self.room.judged(record("hand2", "anna", 2))
        self.assertEqual((one.assignment, two.assignment), (task, None))

    def test_a_session_that_cannot_be_checked_now_does_not_stop_the_others(self):
        first, second = self.room.put(record("anna", "anna")), self.room.put(record("hand1", "anna", 1))
        intake.recording_of(first.pk).unlink()  # a damaged disk
        with self.assertRaises(FileNotFoundError):
            intake.process_waiting()
        second.refresh_from_db()
        self.assertEqual(second.state, "accepted")

    def test_a_reader_that_hangs_or_eats_memory_is_stopped(self):
        with mock.patch.dict(program.LIMITS, {program.resource.RLIMIT_CPU: 1}), self.assertRaises(program.Refused):
            program.typodont("servo", "crown-preparation", "--hand", "expert:", "--out", self.folder / "x.h5")
        with mock.patch.dict(program.LIMITS, {program.resource.RLIMIT_AS: 64 << 20}), self.assertRaises(program.Refused):
            program.check(record("anna", "anna"))

    def test_a_full_disk_during_the_checks_keeps_the_session_waiting(self):
        session = self.room.put(record("anna", "anna"))
        full = shutil.disk_usage("/")._replace(free=1000)
        with mock.patch.object(intake.tempfile, "TemporaryDirectory", side_effect=OSError(errno.ENOSPC, "full")), self.assertRaises(OSError):
            intake.process_waiting()
        with mock.patch.object(intake.program, "score", side_effect=program.Refused("cannot write")), \
                mock.patch.object(intake.shutil, "disk_usage", side_effect=(shutil.disk_usage("/"), full)), self.assertRaises(OSError):
            intake.process_waiting()
        session.refresh_from_db()
        self.assertEqual(session.state, "waiting")
        intake.process_waiting()
        session.refresh_from_db()
        self.assertEqual(session.state, "accepted")


class Started(ServiceTest):
    def test_an_installed_copy_finds_program_texts_and_exercises(self):
        share, tree = self.folder / "share/typodont", intake.settings.TREE
        shutil.copytree(intake.settings.HERE, share / "school/typodont_school")
        shutil.copy(intake.settings.TEXTS, share / "school/typodont_school/report.json")
        (share / "assets").symlink_to(tree / "assets")
        (self.folder / "bin").mkdir()
        (self.folder / "bin/typodont").symlink_to(intake.settings.PROGRAM)
        environment = {**self.environment, "PYTHONPATH": str(share / "school")}
        environment.pop("TYPODONT_SCHOOL_PROGRAM")
        found = subprocess.run([sys.executable, "-c", "from typodont_school import settings as s, words\n"
                                "print(s.PROGRAM, len(list(s.SCENES.glob('*.json'))), words.item('en', 'time_s'))"],
                               env=environment, check=True, capture_output=True, text=True).stdout.split()
        scenes = len(list((tree / "assets/scenes").glob("*.json")))
        self.assertEqual(found, [str(self.folder / "bin/typodont"), str(scenes), "Time"])

    def test_one_command_starts_it_and_a_kill_at_any_point_loses_nothing(self):
        server, bench = self.start_with_bench(3)
        sent = subprocess.Popen(bench, env=self.environment, stdout=subprocess.PIPE, text=True)
        sent.stdout.readline()  # one is handed in; the next is on its way
        server.kill()
        server.wait()
        sent.communicate()
        server, _ = self.start()
        self.assertEqual(subprocess.run(bench, env=self.environment, capture_output=True).returncode, 0)
        self.wait_for_checks(server, 3)
