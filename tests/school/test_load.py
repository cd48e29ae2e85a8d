"""A day of a room of benches in which everything fails, and the times of pages with many sessions."""
import contextlib
import os
import pathlib
import random
import re
import shutil
import socket
import socketserver
import sqlite3
import subprocess
import threading
import time
from collections import Counter
from datetime import timedelta
from unittest import mock

import h5py
from django.conf import settings
from django.contrib.auth.models import User
from django.db import connection
from django.test import Client, TestCase
from django.test.utils import CaptureQueriesContext
from django.urls import reverse
from django.utils import timezone

from crowd import crowd
from room import Room, record, sha256, user
from service import ServiceTest
from typodont_school import hand_in, interface, views
from typodont_school.models import Class, ScoreItem, Session, Student

STRESS = float(os.environ.get("TYPODONT_STRESS", 1))
DAY = 8 * 3600  # s
HAND_USES = 8  # recordings of one hand, of which the service accepts one
hand_in.CHUNK = 60_000
WRONG_CLOCKS = ("1970-01-01T00:00:00Z", "2099-12-31T23:59:59Z", "2026-02-30T25:61:00Z", "")


class Proxy(socketserver.ThreadingTCPServer):
    """A network that cuts requests and loses answers. `faults` are injected one by one, at random connections."""
    daemon_threads = allow_reuse_address = True

    def __init__(self, port, faults, dice):
        super().__init__(("127.0.0.1", 0), Connection)
        self.port, self.faults, self.dice, self.done, self.lock = port, faults, dice, Counter(), threading.Lock()
        self.address = f"http://127.0.0.1:{self.server_address[1]}"
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def handle_error(self, *_):  # the service or the bench is away
        pass


class Connection(socketserver.BaseRequestHandler):
    def handle(self):
        server = self.server
        with server.lock:
            fault = server.faults.pop() if server.faults and server.dice.random() < 0.5 else "none"
            server.done[fault] += 1
            cut = server.dice.random()
        with socket.create_connection(("127.0.0.1", server.port), timeout=60) as service:
            request = b""
            while b"\r\n\r\n" not in request and (block := self.request.recv(1 << 16)):
                request += block
            body = re.search(rb"(?i)\r\ncontent-length: (\d+)", request)
            left = request.index(b"\r\n\r\n") + 4 + (int(body[1]) if body else 0) - len(request)
            while left > 0 and (block := self.request.recv(min(left, 1 << 16))):
                request, left = request + block, left - len(block)
            if fault == "cut request":
                request = request[:int(cut * len(request))]
            service.sendall(request)
            if fault == "cut request":
                return
            answer = b""
            while block := service.recv(1 << 16):
                answer += block
            if fault == "cut answer":
                answer = answer[:int(cut * len(answer))]
            if fault != "lost answer":
                self.request.sendall(answer)


class Bench(threading.Thread):
    """A bench whose folder fills in the course of a day, and what its hand_in.py does."""
    def __init__(self, folder, service, sessions, dice):
        super().__init__(daemon=True)
        self.folder, self.service, self.sessions, self.dice, self.said, self.left = folder, service, sessions, dice, Counter(), 0
        folder.mkdir()

    def run(self):
        for pause, file in self.sessions:
            time.sleep(pause)
            if (signature := file.with_name(file.name + ".sig")).exists():
                shutil.copy(signature, self.folder)
            part = shutil.copy(file, self.folder / "part")
            if file.stem.startswith("clock"):
                os.utime(part, (self.dice.randrange(1 << 32),) * 2)
            os.replace(part, self.folder / file.name)
            self.send()
        while self.send():
            time.sleep(self.dice.uniform(0.5, 1.5))

    def send(self):
        said = lambda text: self.said.update([re.sub(r"^\S+: |\d+", "", text)[:60]])
        return hand_in.Folder(self.folder).hand_in(self.service, said)


class SmallDisk:
    """A file system in memory that another file fills. Mounting needs `unshare -rm`, or root."""
    def __init__(self, test, folder, size):
        folder.mkdir()
        self.filler = folder / "filler"
        self.mounted = not subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], capture_output=True).returncode
        if self.mounted:
            test.addCleanup(subprocess.run, ["umount", "-l", folder])

    def fill(self, left):
        """Leaves this number of free bytes."""
        with open(self.filler, "wb") as out, contextlib.suppress(OSError):  # somebody else was faster
            os.posix_fallocate(out.fileno(), 0, max(1, shutil.disk_usage(self.filler.parent).free - left))

    def empty(self):
        self.filler.unlink(missing_ok=True)


class Campaign(ServiceTest):
    """With TYPODONT_STRESS=10: 50 benches, 400 sessions of a day, 1,000 faults. TYPODONT_SEED changes all of them."""

    def setUp(self):
        super().setUp()
        self.environment.pop("TYPODONT_SCHOOL_DATABASE", None)
        self.dice = random.Random(int(os.environ.get("TYPODONT_SEED", 68)))
        self.injected = Counter()

    def test_no_session_of_a_day_is_lost_or_counted_twice_whatever_fails(self):
        dice, benches, faults = self.dice, int(min(50, 10 * STRESS)), int(100 * STRESS)
        sessions = benches * int(min(8, max(2, STRESS)))
        disk = SmallDisk(self, self.folder / "data", (512 << 20) + (2 << 20) * sessions)
        server, said = self.start()
        self.sign_in(said)
        files = self.recordings(sessions, self.students(20))
        network = [kind for kind in ("cut request", "cut answer", "lost answer") for _ in range(faults * 28 // 100)]
        dice.shuffle(network)
        proxy = Proxy(int(self.address.rpartition(":")[2]), network, dice)
        self.addCleanup(proxy.server_close)
        self.addCleanup(proxy.shutdown)
        room = [self.bench(number, files[number::benches], proxy, sessions / 2 / DAY) for number in range(benches)]
        began = time.monotonic()
        for bench in room:
            bench.start()
        rest = faults - len(network) - self.injected["wrong clock"]
        todo = [kind for kind, count in (("killed server", rest // 4), ("full disk", rest // 4 * disk.mounted), ("lost list", rest // 4), ("two at once", rest - 3 * (rest // 4)))
                for _ in range(count)]
        dice.shuffle(todo)
        while any(bench.is_alive() for bench in room):
            time.sleep(dice.uniform(0, 0.5))
            if todo:
                server = self.inject(todo.pop(), server, disk, room)
        for kind in todo:  # the benches are through: each sends everything again
            server = self.inject(kind, server, disk, room)
        for bench in room:
            (bench.folder / ".handed-in.json").unlink(missing_ok=True)
            bench.send()
        sent = time.monotonic() - began
        self.wait_until_checked(server)
        self.injected += proxy.done
        del self.injected["none"]
        print(f"{benches} benches, {sessions} sessions, sent in {sent:.0f} s, checked in {time.monotonic() - began:.0f} s, {sum(self.injected.values())} faults: "
              + ", ".join(f"{kind} {count}" for kind, count in sorted(self.injected.items())))
        for text, count in sum((bench.said for bench in room), Counter()).most_common():
            print(f"  {count} times: {text}")
        self.judge(files)

    def students(self, count):
        page = self.post("/administration/class", "/administration", name="day", teacher="")
        group = re.search(r'href="(/class/\d+)"', page)[1]
        return re.findall(r"<td>(s-\w+)</td>", self.post(group + "/students", group, students="\n".join(f"student {i}" for i in range(count))))

    def recordings(self, count, students):
        """Returns real recordings, and copies of their hands under other names, dates and clocks."""
        hands = [record(f"hand{seed}", self.dice.choice(students), seed) for seed in range(count // HAND_USES)]
        files = list(hands)
        (self.folder / "made").mkdir()
        while len(files) < count:
            clock = len(files) % 5 == 0
            file = pathlib.Path(shutil.copy(self.dice.choice(hands), self.folder / "made" / f"{'clock' if clock else 'copy'}{len(files)}.h5"))
            date = self.dice.choice(WRONG_CLOCKS) if clock else f"2026-03-{len(files) % 28 + 1:02d}T10:{self.dice.randrange(60):02d}:00Z"
            with h5py.File(file, "a") as f:
                for name, text in (("trainee", self.dice.choice(students)), ("date", date), ("note", str(len(files)))):
                    f.attrs.create(name, text.encode(), dtype=h5py.string_dtype("utf-8", len(text.encode()) or 1))
            self.injected["wrong clock"] += clock
            files.append(file)
        self.dice.shuffle(files)
        return files

    def bench(self, number, files, proxy, speed):
        token, key = self.add_bench(f"bench {number}")
        if number % 5 == 0:
            (self.folder / "key").write_text(key + "\n")
            (self.folder / "key").chmod(0o600)
            for file in files:
                subprocess.run([settings.PROGRAM, "sign", "--key", self.folder / "key", file], check=True, capture_output=True)
        pauses = [self.dice.expovariate(len(files) / DAY) * speed for _ in files]
        return Bench(self.folder / f"bench{number}", hand_in.Service(proxy.address, token), list(zip(pauses, files)), random.Random(self.dice.random()))

    def inject(self, kind, server, disk, room):
        """Returns the server, which may be a new one."""
        dice, self.injected[kind] = self.dice, self.injected[kind] + 1
        if kind == "killed server":
            server.kill()
            server.wait()
            server, _ = self.start()
        elif kind == "full disk":
            disk.fill(dice.choice((0, 0, 10_000, 100_000, 1 << 20, 70 << 20)))
            time.sleep(dice.uniform(0, 1))
            disk.empty()
        elif kind == "lost list":
            (dice.choice(room).folder / ".handed-in.json").unlink(missing_ok=True)
        else:  # the operator's window sends while the watch does
            dice.choice(room).send()
        return server

    def asked(self, query):
        with sqlite3.connect(f"file:{self.folder}/data/school.sqlite?mode=ro", uri=True) as database:
            return database.execute(query).fetchall()

    def wait_until_checked(self, server):
        while self.asked("select count(*) from typodont_school_session where state = 'waiting'") != [(0,)]:
            self.assertIsNone(server.poll())
            time.sleep(1)

    def judge(self, files):
        """Everything is on the server once, whole, and numbered; each hand counts once."""
        data, wanted = self.folder / "data", {sha256(file): file for file in files}
        rows = self.asked("select sha256, state, reason, student_id, exercise_id, attempt, force_hash from typodont_school_session")
        self.assertEqual(sorted(row[0] for row in rows), sorted(wanted))
        stored = [file for file in (data / "sessions").rglob("*.h5")]
        self.assertEqual(sorted(file.stem for file in stored), sorted(wanted))
        for file in stored:
            self.assertEqual(file.read_bytes(), wanted[file.stem].read_bytes())
        self.assertEqual(list((data / "incoming").iterdir()), [])
        self.assertEqual({row[2] for row in rows if row[1] == "refused"}, {"the hand of an earlier session"})
        hands = Counter(row[6] for row in rows if row[1] == "accepted")
        self.assertEqual((len(hands), set(hands.values())), (len(files) // HAND_USES, {1}))
        numbers = {}
        for _, state, _, student, exercise, attempt, _ in rows:
            if state == "accepted":
                numbers.setdefault((student, exercise), []).append(attempt)
        for attempts in numbers.values():
            self.assertEqual(sorted(attempts), list(range(1, len(attempts) + 1)))
        self.assertEqual((self.asked("pragma integrity_check"), self.asked("pragma foreign_key_check")), ([("ok",)], []))


class Pages(TestCase):
    def test_the_number_of_queries_of_a_page_does_not_grow_with_sessions(self):
        """With TYPODONT_STRESS=50 up to 100,000 sessions. The times are printed, not judged: they depend on the machine."""
        room, queries = Room(), []
        models = [room.judged(record("anna", "anna")), room.judged(record("crown", "anna", 4, "remove-caries"))]
        for sessions in sorted({max(1000, int(share * STRESS)) for share in (0, 200, 2000)}):
            ScoreItem.objects.exclude(session__student=room.anna).delete()
            Session.objects.exclude(student=room.anna).delete()
            Student.objects.filter(pseudonym__startswith="s-").delete()
            User.objects.filter(username__startswith="s-").delete()
            Class.objects.filter(name__startswith="Year").delete()
            people = crowd(room, models, 20, 25, sessions)
            with connection.cursor() as cursor:
                cursor.execute("analyze")
            rows, asked = {}, {}
            for person in people[::23]:
                for name, client, path, headers in self.pages(room, person):
                    with CaptureQueriesContext(connection) as counted:
                        begin, cpu = time.perf_counter(), time.thread_time()
                        answer = client.get(path, **headers)
                        self.assertEqual(answer.status_code, 200, name)
                        b"".join(answer) if answer.streaming else answer.content
                        rows.setdefault(name, []).append((1000 * (time.perf_counter() - begin), 1000 * (time.thread_time() - cpu)))
                    asked[name] = len(counted)
                    connection.queries_log.clear()
            queries.append(asked)
            for name, times in rows.items():
                wall, own = (sorted(column) for column in zip(*times))
                at = lambda row, share: row[int(share * len(row))]
                print(f"| {sessions} | {name} | {at(wall, 0.5):.0f} | {at(wall, 0.95):.0f} | {at(own, 0.5):.0f} | {at(own, 0.95):.0f} | {asked[name]} |")
            if connection.vendor == "sqlite":
                print(f"database: {os.path.getsize(connection.settings_dict['NAME']) / sessions:.0f} bytes a session")
        for row in queries[1:]:
            self.assertEqual(row, queries[0])

    def test_the_list_of_classes_gives_each_class_its_own_numbers(self):
        room = Room()
        crowd(room, [room.judged(record("anna", "anna"))], 3, 5, 200)
        Student.objects.get(pseudonym="s-0201").classes.add(Class.objects.get(name="Year 3, group 1"))  # in two classes
        client = Client()
        client.force_login(room.admin)
        month = timezone.now() - timedelta(days=30)
        for row in client.get("/classes").context["rows"]:
            of_class = [session for student in row.students.all() for session in student.session_set.all()]
            points = [session.points for session in of_class if session.received > month]
            self.assertEqual((row.size, row.last, row.recent), (row.students.count(), max((s.received for s in of_class), default=None), len(points)))
            self.assertAlmostEqual(row.mean or 0, sum(points) / max(1, len(points)))

    def test_a_page_of_an_exercise_shows_the_defects_of_its_last_sessions(self):
        room = Room()
        model = room.judged(record("anna", "anna"))
        people = crowd(room, [model], 1, 5, 60)
        client = Client()
        client.force_login(room.admin)
        with mock.patch.object(views, "DEFECT_SESSIONS", 10):
            page = client.get(reverse("exercise", args=[people[0].classes.get().pk, model.exercise_id]))
        last = Session.objects.filter(student__in=people).order_by("-received")[:10]
        for defect in page.context["defects"]:
            items = [session.items.get(name=defect["name"]) for session in last]
            self.assertAlmostEqual(defect["lost"], sum(item.full - item.points for item in items) / 10)
            self.assertAlmostEqual(defect["mean"], sum(item.value for item in items) / 10)
        self.assertContains(page, "Of the last 10 sessions.")

    def pages(self, room, person):
        """Every page that grows with what is stored: name, client, address, headers."""
        group, shown = person.classes.get(), person.session_set.first()
        person.user = person.user or user(person.pseudonym)
        person.save()
        teacher, admin, student, bench = (Client() for _ in range(4))
        for client, account in ((teacher, room.teacher_A), (admin, room.admin), (student, person.user)):
            client.force_login(account)
        token = {"HTTP_AUTHORIZATION": "Bearer " + room.token, "HTTP_X_STUDENT": interface.token_of(person, room.bench)}
        own, one = reverse("student", args=[person.pk]), reverse("session", args=[shown.pk])
        yield from ((name, client, path, {}) for name, client, path in (
            ("classes, administrator", admin, "/classes"), ("classes, teacher", teacher, "/classes"), ("class", teacher, reverse("class", args=[group.pk])),
            ("exercise", teacher, reverse("exercise", args=[group.pk, shown.exercise_id])), ("student, teacher", teacher, own), ("student, own", student, own),
            ("session, teacher", teacher, one), ("session, own", student, one), ("administration", admin, "/administration"),
            ("scores.csv", teacher, reverse("scores_csv", args=[group.pk])), ("statements.json", teacher, reverse("statements", args=[group.pk])),
            ("export.zip", student, reverse("export", args=[person.pk]))))
        yield "bench: a student's scores", bench, "/api/me", token
        yield "bench: hand-in", bench, reverse("hand_in", args=[shown.pk]), token
