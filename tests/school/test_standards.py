"""The school's other systems: LTI 1.3 with a simulated platform, OneRoster 1.2, xAPI, CSV."""
import csv
import http.server
import io
import json
import pathlib
import re
import tempfile
import threading
import time
import urllib.parse
import uuid
import zipfile
from datetime import timedelta

import jwt
from cryptography.hazmat.primitives.asymmetric import rsa
from django.contrib.auth.models import User
from django.core.files.uploadedfile import SimpleUploadedFile
from django.test import Client, TestCase
from django.urls import reverse
from django.utils import timezone

from room import PASSWORD, Room, record
from typodont_school import lti, oneroster, words, xapi
from typodont_school.models import Assignment, Class, Exercise, Grade, Identity, Launch, Platform, Session, Student

ISSUER, CLIENT = "https://platform.example", "tool-1"
KEY, OTHER_KEY = (rsa.generate_private_key(public_exponent=65537, key_size=2048) for _ in range(2))


class LearningSystem(http.server.BaseHTTPRequestHandler):
    """Gives tokens for the tool's signed assertion, and takes scores."""
    scores, assertions, failing = [], [], False

    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        if self.path == "/token":
            self.assertions.append(urllib.parse.parse_qs(body.decode()))
            answer = {"access_token": "t0ken"}
        else:
            answer = {}
            if not self.failing and self.headers["Authorization"] == "Bearer t0ken":
                self.scores.append((self.path, json.loads(body), self.headers["Content-Type"]))
        data = json.dumps(answer).encode()
        self.send_response(503 if self.failing else 200)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, *_):
        pass


class Launches(TestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), LearningSystem)
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()
        cls.addClassCleanup(cls.server.server_close)
        cls.addClassCleanup(cls.server.shutdown)

    def setUp(self):
        self.room = Room()
        self.base = f"http://127.0.0.1:{self.server.server_port}"
        public = json.loads(jwt.algorithms.RSAAlgorithm.to_jwk(KEY.public_key()))
        self.platform = Platform.objects.create(issuer=ISSUER, client_id=CLIENT, deployment="d1", sign_in_url=ISSUER + "/auth",
                                                token_url=self.base + "/token", keys={"keys": [{**public, "kid": "k1"}]})
        LearningSystem.scores.clear()
        LearningSystem.failing = False

    def begin(self, client=None):
        client = client or Client()
        answer = client.get("/lti/sign-in", {"iss": ISSUER, "client_id": CLIENT, "login_hint": "u", "target_link_uri": "x"})
        self.assertEqual(answer.status_code, 302)
        return client, dict(urllib.parse.parse_qsl(urllib.parse.urlsplit(answer["Location"]).query))

    def claims(self, fresh, **changes):
        now = int(time.time())
        return {"iss": ISSUER, "aud": CLIENT, "sub": "subject-anna", "iat": now, "exp": now + 300, "nonce": fresh,
                lti.CLAIM + "version": "1.3.0", lti.CLAIM + "message_type": "LtiResourceLinkRequest", lti.CLAIM + "deployment_id": "d1",
                lti.CLAIM + "roles": [lti.ROLE + "Learner"], lti.CLAIM + "context": {"id": "class-A"},
                lti.CLAIM + "lis": {"person_sourcedid": "id-anna"}, **changes}

    def launch(self, key=KEY, kid="k1", algorithm="RS256", token=None, **changes):
        client, query = self.begin()
        token = token(self.claims(query["nonce"])) if token else jwt.encode(self.claims(query["nonce"], **changes), key, algorithm, headers={"kid": kid})
        return client, client.post("/lti/launch", {"state": query["state"], "id_token": token})

    def test_a_launch_signs_in_the_student_of_the_roster(self):
        client, answer = self.launch()
        self.assertEqual(answer.status_code, 302)
        self.assertEqual(client.get("/")["Location"], reverse("student", args=[self.room.anna.pk]))

    def test_a_new_subject_gets_a_pseudonym_and_the_class(self):
        changes = {"sub": "new", lti.CLAIM + "lis": {}}
        self.launch(**changes)
        self.launch(**changes)
        student = Identity.objects.get(subject="new").user.student
        self.assertEqual(list(student.classes.all()), [self.room.class_A])
        self.assertNotIn("new", student.pseudonym)

    def test_an_instructor_gets_the_class_and_no_other(self):
        client, _ = self.launch(sub="prof", **{lti.CLAIM + "roles": [lti.ROLE + "Instructor"], lti.CLAIM + "lis": {}})
        self.assertEqual(client.get(reverse("class", args=[self.room.class_A.pk])).status_code, 200)
        self.assertEqual(client.get(reverse("class", args=[self.room.class_B.pk])).status_code, 403)

    def test_every_forged_launch_is_refused(self):
        now = int(time.time())
        unsigned = lambda claims: jwt.encode(claims, None, "none", headers={"kid": "k1"})
        for name, options in {
                "another key": {"key": OTHER_KEY}, "unknown key id": {"kid": "k2"}, "wrong issuer": {"iss": "https://evil.example"},
                "another client": {"aud": "tool-2"}, "two clients without azp": {"aud": [CLIENT, "tool-2"]}, "expired": {"exp": now - 61, "iat": now - 400},
                "from the future": {"iat": now + 120, "exp": now + 500}, "another nonce": {"nonce": "guess"},
                "another deployment": {lti.CLAIM + "deployment_id": "d2"}, "another version": {lti.CLAIM + "version": "1.1"},
                "another message": {lti.CLAIM + "message_type": "LtiDeepLinkingRequest"}, "no token": {"token": lambda claims: "x"},
                "no signature": {"token": unsigned}, "a symmetric signature": {"key": "secret", "algorithm": "HS256"}}.items():
            with self.subTest(name):
                client, answer = self.launch(**options)
                self.assertEqual(answer.status_code, 403)
                self.assertEqual(client.get("/").status_code, 302)
                self.assertIn("/sign-in", client.get("/")["Location"])

    def test_clocks_may_differ_by_a_minute(self):
        now = int(time.time())
        self.assertEqual(self.launch(exp=now - 30, iat=now - 400)[1].status_code, 302)
        self.assertEqual(self.launch(iat=now + 30)[1].status_code, 302)

    def test_a_launch_counts_once_and_in_its_own_browser(self):
        client, query = self.begin()
        form = {"state": query["state"], "id_token": jwt.encode(self.claims(query["nonce"]), KEY, "RS256", headers={"kid": "k1"})}
        self.assertEqual(Client().post("/lti/launch", form).status_code, 403)
        self.assertEqual(client.post("/lti/launch", form).status_code, 302)
        self.assertEqual(client.post("/lti/launch", form).status_code, 403)
        client, query = self.begin()
        Launch.objects.update(started=timezone.now() - timedelta(minutes=11))
        self.assertEqual(client.post("/lti/launch", {**form, "state": query["state"]}).status_code, 403)

    def test_an_administrator_registers_a_platform(self):
        client = Client()
        client.login(username="root", password=PASSWORD)
        told = {"issuer": "https://new.example", "client_id": "c", "deployment": "d", "sign_in_url": "https://new.example/a", "token_url": "https://new.example/t",
                "keys": self.platform.keys["keys"]}
        self.assertEqual(client.post("/administration/platform", {"settings": "{}"}).status_code, 400)
        self.assertEqual(client.post("/administration/platform", {"settings": json.dumps(told)}).status_code, 302)
        self.assertEqual(Client().get("/lti/sign-in", {"iss": "https://new.example"}).status_code, 302)

    def test_an_unknown_platform_is_refused(self):
        self.assertEqual(Client().get("/lti/sign-in", {"iss": "https://evil.example"}).status_code, 403)

    def test_an_administrator_is_never_signed_in_by_a_platform(self):
        Identity.objects.create(platform=self.platform, subject="boss", user=self.room.admin)
        self.assertEqual(self.launch(sub="boss", **{lti.CLAIM + "lis": {}})[1].status_code, 403)

    def test_the_best_score_of_an_assignment_is_sent_again_until_it_arrives(self):
        task = Assignment.objects.create(group=self.room.class_A, exercise=self.room.exercise, due=timezone.now() + timedelta(days=1))
        self.launch(**{lti.AGS: {"lineitem": self.base + "/items/7?type=2"}, lti.CLAIM + "custom": {"assignment": task.pk}})
        LearningSystem.failing = True
        session = self.room.judged(record("anna", "anna"))
        self.assertEqual((lti.send_grades(), Grade.objects.get().tries), (0, 1))
        LearningSystem.failing = False
        self.assertEqual((lti.send_grades(), lti.send_grades()), (1, 0))
        (path, score, kind), = LearningSystem.scores
        self.assertEqual((path, kind), ("/items/7/scores?type=2", "application/vnd.ims.lis.v1.score+json"))
        self.assertEqual((score["userId"], score["scoreGiven"], score["scoreMaximum"]), ("subject-anna", round(session.points, 2), 100))
        form = LearningSystem.assertions[-1]
        own = jwt.algorithms.RSAAlgorithm.from_jwk(json.dumps(Client().get("/lti/keys.json").json()["keys"][0]))
        told = jwt.decode(form["client_assertion"][0], own, ["RS256"], audience=self.base + "/token")
        self.assertEqual((told["iss"], told["sub"], form["scope"]), (CLIENT, CLIENT, [lti.SCORE_SCOPE]))

    def test_a_line_item_elsewhere_or_of_another_class_gets_no_grades(self):
        task = Assignment.objects.create(group=self.room.class_B, exercise=self.room.exercise, due=timezone.now() + timedelta(days=1))
        self.launch(**{lti.AGS: {"lineitem": self.base + "/items/7"}, lti.CLAIM + "custom": {"assignment": task.pk}})
        self.launch(**{lti.AGS: {"lineitem": "http://evil.example/items"}, lti.CLAIM + "custom": {"assignment": task.pk}})
        task.refresh_from_db()
        self.assertEqual(task.line_item, "")


def roster(**changes):
    tables = {"manifest.csv": "propertyName,value\nmanifest.version,1.0\noneroster.version,1.2\n",
              "orgs.csv": "sourcedId,status,dateLastModified,name,type,identifier,parentSourcedId\no1,,,Dental School,school,,\n",
              "classes.csv": "sourcedId,status,dateLastModified,title,grades,courseSourcedId,classCode,classType,location,schoolSourcedId\nc1,,,Year 3,,k1,,scheduled,,o1\n",
              "users.csv": "sourcedId,status,dateLastModified,enabledUser,username,givenName,familyName\nu1,,,true,mmuster,Maria,Muster\nu2,,,true,jdoe,John,Doe\nu3,tobedeleted,,true,x,X,X\n",
              "enrollments.csv": "sourcedId,status,dateLastModified,classSourcedId,schoolSourcedId,userSourcedId,role,primary\ne1,,,c1,o1,u1,student,\ne2,,,c1,o1,u2,teacher,true\n", **changes}
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as packed:
        for name, text in tables.items():
            packed.writestr(name, text)
    out.seek(0)
    return out


class Rosters(TestCase):
    def test_people_come_in_as_pseudonyms_and_can_sign_in(self):
        people = {row["identifier"]: row for row in oneroster.read(roster())}
        group = Class.objects.get(source_id="c1")
        self.assertEqual((group.name, group.students.get().source_id, group.teachers.get().username), ("Year 3", "u1", people["u2"]["pseudonym"]))
        self.assertTrue(Client().login(username=people["u1"]["pseudonym"], password=people["u1"]["password"]))
        stored = json.dumps(list(User.objects.values()) + list(Student.objects.values()), default=str)
        for name in ("Maria", "Muster", "mmuster", "Doe"):
            self.assertNotIn(name, stored)

    def test_the_same_roster_again_changes_nothing_and_a_new_one_moves_people(self):
        oneroster.read(roster())
        before = list(Student.objects.values_list("pk", "pseudonym"))
        self.assertEqual(oneroster.read(roster()), [])
        self.assertEqual(list(Student.objects.values_list("pk", "pseudonym")), before)
        oneroster.read(roster(**{"enrollments.csv": "classSourcedId,userSourcedId,role\nc1,u2,teacher\n"}))
        self.assertEqual(Class.objects.get(source_id="c1").students.count(), 0)

    def test_broken_rosters_are_refused_whole(self):
        for name, file in {"no zip": io.BytesIO(b"x"), "no such column": roster(**{"users.csv": "id\n1\n"}),
                           "unknown class": roster(**{"enrollments.csv": "classSourcedId,userSourcedId,role\nc9,u1,student\n"}),
                           "a long value": roster(**{"orgs.csv": f"sourcedId,name,type\no1,{'x' * 200},school\n"}),
                           "no text": roster(**{"users.csv": b"\xff\xfe\x00"}), "class without school": roster(**{"orgs.csv": "sourcedId,name,type\n"}),
                           "too large": roster(**{"users.csv": b"sourcedId,enabledUser\n" + b"a" * (oneroster.MAX_BYTES + 1)})}.items():
            with self.subTest(name), self.assertRaises(oneroster.Unreadable):
                oneroster.read(file)
        self.assertEqual((Class.objects.count(), User.objects.count()), (0, 0))

    def test_an_administrator_imports_a_roster_in_the_browser(self):
        Room()
        client = Client()
        client.login(username="root", password=PASSWORD)
        answer = client.post("/administration/roster", {"file": SimpleUploadedFile("roster.zip", roster().read())})
        self.assertContains(answer, Student.objects.get(source_id="u1").pseudonym)

    def test_a_class_made_by_hand_has_a_teacher_and_students_who_can_sign_in(self):
        room, client = Room(), Client()
        client.login(username="root", password=PASSWORD)
        unknown = client.post("/administration/class", {"name": "Year 3", "teacher": "anna"})
        self.assertEqual((unknown.status_code, Class.objects.count()), (400, 2))
        made = client.post("/administration/class", {"name": "Year 3"}).context
        added = client.post(f"/class/{made['group'].pk}/students", {"students": "17\n\nanna\n17\n18"}).context["people"]
        self.assertEqual([person["identifier"] for person in added], ["17", "18"])
        pseudonyms = {person["pseudonym"] for person in added}
        self.assertEqual({s.pseudonym for s in made["group"].students.all()}, pseudonyms | {"anna"})
        self.assertNotIn("17", {s.source_id for s in Student.objects.all()})
        self.assertIn(room.class_A, room.anna.classes.all())
        for person in made["people"] + added:
            self.assertTrue(Client().login(username=person["pseudonym"], password=person["password"]))
        teacher = Client()
        teacher.login(username=made["people"][0]["pseudonym"], password=made["people"][0]["password"])
        self.assertContains(teacher.get(f"/class/{made['group'].pk}"), added[0]["pseudonym"])
        self.assertEqual(teacher.get(f"/class/{room.class_A.pk}").status_code, 403)


class Cases(TestCase):
    def test_a_case_is_handed_out_and_its_sessions_count(self):
        room, teacher, student = Room(), Client(), Client()
        teacher.login(username="teacherA", password=PASSWORD)
        student.login(username="anna", password=PASSWORD)
        wanted = {"family": "class-1", "seed": "7", "difficulty": "40"}
        address = reverse("add_case", args=[room.class_A.pk])
        for wrong in ({"family": "../class-1"}, {"seed": "-1"}, {"difficulty": "101"}, {"seed": "x"}):
            self.assertEqual(teacher.post(address, {**wanted, **wrong}).status_code, 400)
        self.assertEqual(teacher.post(address, wanted).status_code, 302)
        case = Exercise.objects.get(name="class-1-7-40")
        teacher.post(reverse("assign", args=[room.class_A.pk]), {"exercise": case.pk, "due": "2099-01-01T00:00", "attempts": "1"})
        files = reverse("case_files", args=[case.pk])
        self.assertContains(student.get(reverse("student", args=[room.anna.pk])), files)
        with tempfile.TemporaryDirectory() as bench:
            zipfile.ZipFile(io.BytesIO(b"".join(student.get(files).streaming_content))).extractall(bench)
            session = room.judged(record("case", "anna", scene=pathlib.Path(bench) / "class-1-7-40.json"))
        self.assertEqual((session.state, session.reason, session.exercise), (Session.ACCEPTED, "", case))
        self.assertEqual(session.assignment.exercise, case)


class Exports(TestCase):
    def setUp(self):
        self.room = Room()
        self.session = self.room.judged(record("anna", "anna"))
        self.client.login(username="teacherA", password=PASSWORD)

    def test_statements_are_those_of_xapi_and_keep_their_id(self):
        statement, = self.client.get(reverse("statements", args=[self.room.class_A.pk])).json()
        items = {item.name: item.value for item in self.session.items.all()}
        self.assertEqual(statement, json.loads(json.dumps(xapi.statement(self.session, items))))
        uuid.UUID(statement["id"])
        self.assertEqual(statement["actor"]["account"]["name"], "anna")
        self.assertAlmostEqual(statement["result"]["score"]["scaled"], self.session.points / 100, 6)
        self.assertRegex(statement["result"]["duration"], r"^PT[\d.]+S$")
        known = {row["id"] for row in self.client.get("/xapi/profile.json").json()["concepts"]}
        used = [statement["object"]["definition"]["type"], *statement["result"]["extensions"], *statement["context"]["extensions"]]
        self.assertLessEqual(set(used), known)

    def test_a_table_holds_every_score_and_no_formula(self):
        self.room.anna.pseudonym = "=cmd()"
        self.room.anna.save()
        rows = list(csv.DictReader(io.StringIO(self.client.get(reverse("scores_csv", args=[self.room.class_A.pk])).content.decode())))
        self.assertEqual((len(rows), rows[0]["pseudonym"], float(rows[0]["points"])), (1, "'=cmd()", self.session.points))

    def test_titles_of_scores_and_places_are_the_programs(self):
        self.assertEqual(words.item("de", "over_cut_mm3"), "Zu tief abgetragen, Volumen")
        self.assertEqual(words.place("en", "part.wall side.lingual"), "wall, lingual")

    def test_every_text_exists_in_three_languages(self):
        for key, texts in words.TEXTS.items():
            self.assertEqual(len(texts), len(words.LANGUAGES), key)
            self.assertEqual(len({tuple(sorted(re.findall(r"{\w+}", text))) for text in texts}), 1, key)
