"""Who may see what: every address, every role."""
import io
import json
import re
import zipfile

from django.core.management import call_command
from django.test import Client, TestCase
from django.urls import reverse

from room import PASSWORD, Room, record
from typodont_school import intake, urls
from typodont_school.models import Assignment, Remark, ScoreItem, Session, SignInFailure, Student

STAFF_A = {"teacherA", "root"}
OWN = {"anna", "teacherA", "root"}  # what is about anna, of class A
EVERYBODY = {"anna", "ben", "carl", "teacherA", "teacherB", "root"}
ALLOWED = {"home": EVERYBODY, "password": EVERYBODY, "sign_out": EVERYBODY, "classes": {"teacherA", "teacherB", "root"},
           "class": STAFF_A, "exercise": STAFF_A, "assign": STAFF_A, "scores_csv": STAFF_A, "scores_json": STAFF_A, "statements": STAFF_A,
           "add_case": STAFF_A, "case_files": EVERYBODY,
           "student": OWN, "export": OWN, "session": OWN, "report": OWN, "film": OWN, "film_file": OWN, "recording": OWN, "remarks": OWN, "remark": STAFF_A,
           "delete": {"root"}, "administration": {"root"}, "add_bench": {"root"}, "add_platform": {"root"},
           "add_class": {"root"}, "add_students": {"root"}, "roster": {"root"}}
# Pages without an account: each has its own test of what guards it.
PUBLIC = {"sign_in", "language", "hand_in", "exam", "exam_progress", "bench_sign_in", "me", "assignment_files", "profile", "lti_sign_in", "lti_launch", "lti_keys"}


def plain(response):
    return re.sub(rb'(csrfmiddlewaretoken" value|name="next" value)="[^"]*"', b"", response.content)


class Roles(TestCase):
    @classmethod
    def setUpTestData(cls):
        cls.room = Room()
        cls.session = cls.room.judged(record("anna", "anna"))
        assert cls.session.state == Session.ACCEPTED, cls.session.reason

    def arguments(self, name, absent=False):
        a = self.room
        if name in ("class", "assign", "add_case", "add_students", "scores_csv", "scores_json", "statements"):
            return [999 if absent else a.class_A.pk]
        if name == "exercise":
            return [999 if absent else a.class_A.pk, a.exercise.pk]
        if name == "case_files":
            return [999 if absent else a.exercise.pk]
        if name in ("student", "export", "delete"):
            return [999 if absent else a.anna.pk]
        return ["f" * 64 if absent else self.session.pk] if name in ("session", "report", "film", "film_file", "recording", "remarks", "remark") else []

    def ask(self, who, name, absent=False, **options):
        client = Client(**options)
        if who:
            self.assertTrue(client.login(username=who, password=PASSWORD))
        view = next(p.callback for p in urls.urlpatterns if p.name == name)
        address = reverse(name, args=self.arguments(name, absent))
        return client.post(address) if "POST" in view.methods else client.get(address)

    def test_every_address_has_an_owner_in_the_table(self):
        self.assertEqual({p.name for p in urls.urlpatterns}, set(ALLOWED) | PUBLIC)
        for p in urls.urlpatterns:
            self.assertEqual(p.callback.roles is None, p.name in PUBLIC, p.name)

    def test_every_address_with_every_role(self):
        for name, allowed in ALLOWED.items():
            for who in sorted(EVERYBODY):
                with self.subTest(address=name, who=who):
                    answer = self.ask(who, name)
                    if who in allowed:
                        self.assertNotIn(answer.status_code, (403, 404, 405, 500))
                    else:
                        self.assertEqual(answer.status_code, 403)

    def test_a_forbidden_object_looks_like_an_absent_one(self):
        for name, allowed in ALLOWED.items():
            if not self.arguments(name):
                continue
            for who in sorted(EVERYBODY - allowed):
                with self.subTest(address=name, who=who):
                    there, absent = self.ask(who, name), self.ask(who, name, absent=True)
                    self.assertEqual((there.status_code, absent.status_code), (403, 403))
                    self.assertEqual(plain(there), plain(absent))
                    for hint in (b"anna", b"Class A", b"class I"):
                        self.assertNotIn(hint, there.content.replace(b"(anna)", b""))

    def test_a_student_sees_no_mean_that_tells_the_points_of_few_others(self):
        self.room.judged(record("ben", "ben", 1))
        for who, sees in (("anna", False), ("teacherA", True)):
            self.assertEqual(b'class="mean"' in self.ask(who, "student").content, sees, who)
        for number in range(2):  # four students with a first attempt
            one = Student.objects.create(pseudonym=f"more{number}")
            one.classes.add(self.room.class_A)
            Session.objects.create(sha256=f"{number}" * 64, bench=self.room.bench, size=1, state=Session.ACCEPTED, student=one, exercise=self.room.exercise,
                                   attempt=1, points=50)
        self.assertIn(b'class="mean"', self.ask("anna", "student").content)

    def test_signed_out_people_are_sent_to_the_sign_in_whatever_exists(self):
        for name in ALLOWED:
            for absent in (False, True):
                answer = self.ask(None, name, absent)
                self.assertEqual((answer.status_code, answer["Location"].split("?")[0]), (302, "/sign-in"), name)

    def test_a_closed_account_is_signed_out(self):
        client = Client()
        client.login(username="anna", password=PASSWORD)
        self.room.anna.user.is_active = False
        self.room.anna.user.save()
        self.assertEqual(client.get("/password").status_code, 302)

    def test_no_form_works_without_its_token(self):
        for p in urls.urlpatterns:
            if p.name in ALLOWED and "POST" in p.callback.methods:
                self.assertEqual(self.ask("root", p.name, enforce_csrf_checks=True).status_code, 403, p.name)
        self.assertEqual(Client(enforce_csrf_checks=True).post("/sign-in").status_code, 403)
        self.assertTrue(Student.objects.filter(pseudonym="anna").exists())

    def test_a_password_is_guessed_eight_times_at_most(self):
        client = Client()
        tries = [client.post("/sign-in", {"username": "anna", "password": f"guess {i}"}).status_code for i in range(9)]
        self.assertEqual(tries, [403] * 8 + [429])
        right = {"username": "anna", "password": PASSWORD}
        self.assertEqual(client.post("/sign-in", right).status_code, 429)
        SignInFailure.objects.all().delete()  # as 15 minutes later
        self.assertEqual(client.post("/sign-in", right).status_code, 302)

    def test_sign_in_leads_nowhere_else(self):
        for there in ("https://elsewhere.example/", "//elsewhere.example", "javascript:alert(1)"):
            answer = Client().post("/sign-in", {"username": "anna", "password": PASSWORD, "next": there})
            self.assertEqual(answer["Location"], "/")

    def test_an_export_holds_everything_and_a_deletion_leaves_nothing(self):
        Remark.objects.create(session=self.session, author=self.room.teacher_A, text="good walls", at_s=1.5)
        packed = zipfile.ZipFile(io.BytesIO(b"".join(self.ask("anna", "export").streaming_content)))
        about = json.loads(packed.read("student.json"))
        self.assertEqual(about["sessions"][0]["remarks"][0]["text"], "good walls")
        self.assertEqual(len(about["sessions"][0]["items"]), ScoreItem.objects.filter(session=self.session).count())
        self.assertEqual(packed.read(f"recordings/{self.session.pk}.h5"), intake.recording_of(self.session.pk).read_bytes())
        client = Client()
        client.login(username="root", password=PASSWORD)
        data = intake.recording_of(self.session.pk).read_bytes()
        try:
            client.post(reverse("delete", args=[self.room.anna.pk]), {"pseudonym": "ben"})
            self.assertTrue(Student.objects.filter(pseudonym="anna").exists())
            client.post(reverse("delete", args=[self.room.anna.pk]), {"pseudonym": "anna"})
            self.assertFalse(Student.objects.filter(pseudonym="anna").exists())
            self.assertFalse(Session.objects.filter(pk=self.session.pk).exists())
            self.assertFalse(ScoreItem.objects.exists())
            self.assertFalse([f for f in intake.settings.DATA.rglob("*") if self.session.pk in f.name])
        finally:
            intake.recording_of(self.session.pk).write_bytes(data)  # the other tests' row comes back with the database

    def test_a_teacher_changes_a_remark_and_moves_or_removes_it(self):
        client = Client()
        client.login(username="teacherA", password=PASSWORD)
        address = reverse("remark", args=[self.session.pk])
        self.assertEqual(client.post(address, {"text": "too deep", "at_s": "-1"}).status_code, 400)
        client.post(address, {"text": "too deep", "at_s": "0.4"})
        one = Remark.objects.get()
        client.post(address, {"text": "too deep here", "at_s": "0.5", "number": one.pk})
        file = json.loads(client.get(reverse("remarks", args=[self.session.pk])).content)
        self.assertEqual([(r["author"], r["text"], r["at_s"]) for r in file["remarks"]], [("teacherA", "too deep here", 0.5)])
        client.post(address, {"text": "", "number": one.pk})
        self.assertFalse(Remark.objects.exists())

    def test_a_session_names_the_strokes_of_its_defects(self):
        defects = self.session.defects
        self.assertIn("under_cut_depth_mm", [d["name"] for d in defects])
        for stroke in (s for d in defects for s in d["strokes"]):
            self.assertTrue(0 < stroke["at_s"] < self.session.seconds)

    def test_a_teacher_hands_out_an_exercise(self):
        client = Client()
        client.login(username="teacherA", password=PASSWORD)
        address = reverse("assign", args=[self.room.class_A.pk])
        good = {"exercise": self.room.exercise.pk, "due": "2030-01-01T12:00", "attempts": "2"}
        self.assertEqual(client.post(address, {**good, "attempts": "-1"}).status_code, 400)
        self.assertEqual(client.post(address, good).status_code, 302)
        self.assertEqual(Assignment.objects.get().attempts, 2)

    def test_the_migrations_make_the_models(self):
        call_command("makemigrations", check=True, dry_run=True, verbosity=0)
