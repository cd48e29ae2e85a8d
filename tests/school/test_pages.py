"""The pages in a real browser."""
import base64
import json
import os
import pathlib
import re
import shutil
import struct
import sys
import tempfile
import time
from datetime import timedelta
from unittest import mock

from django.test import Client, LiveServerTestCase, SimpleTestCase
from django.urls import reverse
from django.utils import timezone

from crowd import crowd
from room import PASSWORD, Room, record
from typodont_school import charts, films, program, views
from typodont_school.models import Assignment, Remark, Rescore

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "acceptance"))
from page_accessibility import AFTER_TWO_FRAMES, CONTRAST, Browser  # noqa: E402

AXE = os.environ.get("TYPODONT_AXE")  # axe.min.js of axe-core, which is not shipped
PICTURES = os.environ.get("TYPODONT_PICTURES")
AXE_RUN = "axe.run(document,{resultTypes:['violations']}).then(r=>r.violations.filter(v=>['serious','critical'].includes(v.impact)).map(v=>v.id+': '+v.nodes[0].html))"


class Numbers(SimpleTestCase):
    def test_the_interval_of_a_mean_is_students(self):
        for freedom, quantile in ((3, 3.1824), (5, 2.5706), (10, 2.2281), (30, 2.0423), (1000, 1.9623)):
            self.assertAlmostEqual(charts.student_t(0.975, freedom) / quantile, 1, delta=0.01)
        mean, low, high = charts.mean_interval([50, 60, 70, 80])
        self.assertEqual(mean, 65)
        self.assertAlmostEqual((high - low) / 2, 3.1824 * 12.909944 / 2, delta=0.2)
        self.assertEqual(charts.mean_interval([50, 60, 70])[1:], (None, None))

    def test_a_histogram_counts_every_value_once(self):
        for values in ([1.0], [0, 0, 0], [0, 1, 2, 3.5, 10], [-3, 7], [i / 7 for i in range(50)]):
            svg = charts.histogram("t", values, "x", "y")
            self.assertEqual(sum(int(n) for n in re.findall(r": (\d+)</title></rect>", svg)), len(values))

    def test_texts_of_a_recording_cannot_leave_a_chart(self):
        self.assertNotIn("<b>", charts.histogram('"><b>', [1, 2], "<b>", "<b>", 1.5, "<b>"))


class Pages(LiveServerTestCase):
    static_handler = staticmethod(lambda application: application)  # the service itself serves its files

    def setUp(self):
        self.room = Room()
        self.session = self.room.judged(os.environ.get("TYPODONT_RECORDING") or record("anna", "anna"))
        others = [self.room.judged(record("crown", "anna", 4, "remove-caries"))]
        people = crowd(self.room, [self.session, *others], 2, 24, 900)
        self.session.student = people[0]
        self.session.attempt = 11
        self.session.save()
        self.group = people[0].classes.get()
        Assignment.objects.create(group=self.group, exercise=self.room.exercise, due=timezone.now() + timedelta(days=5))
        Assignment.objects.create(group=self.group, exercise=self.room.exercise, due=timezone.now() + timedelta(days=9), attempts=1, sealed=True)
        Remark.objects.create(session=self.session, author=self.room.teacher_A, text="The floor is even. Next time, keep the bur upright at the lingual wall.")
        Rescore.objects.create(session=self.session, program="0.2.0 (9c91fdf9299b)", points=72, passed=True)
        self.profile = self.enterContext(tempfile.TemporaryDirectory())
        self.browser = Browser(shutil.which("chromium-headless-shell"), self.profile)
        self.addCleanup(self.browser.process.kill)
        ask = self.browser.ask
        self.browser.session = ask("Target.attachToTarget", targetId=ask("Target.createTarget", url="about:blank")["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network"):
            ask(domain + ".enable")

    def open(self, who, path, language="en", width=1280):
        ask = self.browser.ask
        client = Client()
        if who:
            client.login(username=who, password=PASSWORD)
            ask("Network.setCookie", name="sessionid", value=client.cookies["sessionid"].value, url=self.live_server_url)
        else:
            ask("Network.clearBrowserCookies")
        ask("Network.setCookie", name="language", value=language, url=self.live_server_url)
        ask("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
        ask("Page.navigate", url=self.live_server_url + path)
        self.wait(f"location.pathname=={json.dumps(path)} && document.readyState=='complete'")

    def wait(self, condition):
        for _ in range(6000):
            try:
                if self.browser.run(condition):
                    return
            except RuntimeError:  # between two pages
                pass
            time.sleep(0.05)
        self.fail("never: " + condition)

    def in_frame(self, script):
        """Runs a script in the report that a session's page contains."""
        ask = self.browser.ask
        frame = ask("Page.getFrameTree")["frameTree"]["childFrames"][0]["frame"]["id"]
        world = ask("Page.createIsolatedWorld", frameId=frame)["executionContextId"]
        return ask("Runtime.evaluate", expression=script, contextId=world, returnByValue=True)["result"].get("value")

    def test_every_page_is_readable_by_all_at_every_width_and_asks_nobody_else(self):
        a = self.room
        pages = {"sign_in": (None, "/sign-in"), "classes": ("teacherA", "/classes"), "class": ("teacherA", reverse("class", args=[self.group.pk])),
                 "exercise": ("teacherA", reverse("exercise", args=[self.group.pk, a.exercise.pk])),
                 "student": ("s-0101", reverse("student", args=[self.session.student.pk])), "session": ("teacherA", reverse("session", args=[self.session.pk])),
                 "administration": ("root", "/administration"), "password": ("anna", "/password"), "message": ("anna", "/classes")}
        for name, (who, path) in pages.items():
            for language, width in (("en", 1280), ("de", 640), ("zh", 1920)):
                with self.subTest(page=name, language=language, width=width):
                    self.open(who, path, language, width)
                    run = self.browser.run
                    if name == "session":
                        self.assertEqual(self.in_frame("document.getElementById('viewer').dataset.drawn"), "difference")
                        self.assertEqual(self.in_frame("[...document.querySelectorAll('header,nav,section,footer')].filter(e=>e.checkVisibility()).map(e=>e.id)"), ["form"])
                        self.assertLessEqual(self.in_frame("document.documentElement.scrollWidth"), run("document.querySelector('iframe').clientWidth"))
                    self.assertEqual(run("document.documentElement.lang"), language)
                    self.assertLessEqual(run("document.documentElement.scrollWidth"), width)
                    self.assertEqual(run("document.querySelectorAll('h1').length"), 1)
                    self.assertEqual(run("performance.getEntriesByType('resource').map(e=>e.name).filter(n=>!n.startsWith(location.origin)&&!n.startsWith('blob:')&&!n.startsWith('data:'))"), [])
                    self.assertEqual(run("[...document.querySelectorAll('input:not([type=hidden]),select,textarea')].filter(e=>!e.closest('label')).length"), 0)
                    self.assertEqual(run(CONTRAST), [])
                    if AXE:
                        run(pathlib.Path(AXE).read_text() + ";0")
                        self.assertEqual(run(AXE_RUN), [])
                    if PICTURES:
                        self.picture(pathlib.Path(PICTURES) / f"{name}-{language}-{width}.png", width)

    def picture(self, file, width):
        size = self.browser.ask("Page.getLayoutMetrics")["cssContentSize"]
        height = min(size["height"], 1800)
        shot = self.browser.ask("Page.captureScreenshot", captureBeyondViewport=True, clip={"x": 0, "y": 0, "width": width, "height": height, "scale": 1})
        file.write_bytes(base64.b64decode(shot["data"]))

    def test_the_film_is_asked_for_and_appears_when_it_is_ready(self):
        self.open("teacherA", reverse("session", args=[self.session.pk]))
        self.browser.run("document.querySelector('form[action$=film] button').click()")
        self.wait("!!document.querySelector('[data-state=waiting]')")
        self.picture_of("film-waiting")
        with mock.patch.multiple(program, FILM_NICE=0, MAX_FPS=5):  # soon, also on a busy machine
            films.make_waiting()
        self.wait("document.querySelector('video')?.readyState>=1")  # without a key press
        self.assertAlmostEqual(self.browser.run("document.querySelector('video').duration"), self.session.seconds, delta=0.3)
        self.browser.run("document.querySelector('video').currentTime=0.4")
        self.wait("!document.querySelector('video').seeking && document.querySelector('video').readyState>=2")
        self.picture_of("film")
        if AXE:
            self.browser.run(pathlib.Path(AXE).read_text() + ";0")
            self.assertEqual(self.browser.run(AXE_RUN), [])

    def test_a_class_s_scores_are_written_as_a_parquet_file(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.open("teacherA", reverse("class", args=[self.group.pk]))
        self.browser.ask("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(folder), eventsEnabled=False)
        self.browser.run("document.querySelector('[data-parquet]').click()")
        file = folder / "scores.parquet"
        for _ in range(1200):
            if file.exists():
                break
            time.sleep(0.05)
        data, rows = file.read_bytes(), list(views.scores_of(self.group))
        self.assertEqual((data[:4], data[-4:]), (b"PAR1", b"PAR1"))
        self.assertGreater(len(rows), 100)
        for name in views.SCORES:
            self.assertIn(name.encode(), data)
        text = lambda of: struct.pack("<I", len(of)) + of.encode()
        for plain in (struct.pack(f"<{len(rows)}d", *(row[4] for row in rows)),  # points, as Parquet's encoding "plain" has them
                      struct.pack(f"<{len(rows)}q", *(int(row[3].timestamp() * 1000) for row in rows)),  # received
                      b"".join(text(row[8]) for row in rows), *(text(row[0]) for row in rows)):
            self.assertIn(plain, data)

    def picture_of(self, name, width=1280):
        if PICTURES:
            self.picture(pathlib.Path(PICTURES) / f"{name}.png", width)

    def test_the_keyboard_turns_the_result_and_reaches_every_control(self):
        self.open("teacherA", reverse("session", args=[self.session.pk]))
        look = lambda: self.in_frame("document.querySelector('canvas').toDataURL()")
        self.browser.run("document.querySelector('iframe').focus()")
        self.in_frame("document.querySelector('canvas').focus()")
        before = look()
        self.browser.ask("Input.dispatchKeyEvent", type="keyDown", key="ArrowLeft", windowsVirtualKeyCode=37)
        self.browser.run(AFTER_TWO_FRAMES)
        self.assertNotEqual(look(), before)
        self.browser.run("document.body.focus(); document.activeElement.blur()")
        reached = set()
        for _ in range(80):
            self.browser.ask("Input.dispatchKeyEvent", type="keyDown", key="Tab", windowsVirtualKeyCode=9)
            self.browser.ask("Input.dispatchKeyEvent", type="keyUp", key="Tab", windowsVirtualKeyCode=9)
            reached.add(self.browser.run("[...document.querySelectorAll('*')].indexOf(document.activeElement)"))
        controls = self.browser.run("[...document.querySelectorAll('*')].map((e,i)=>[e,i]).filter(([e])=>e.matches('a[href],button,textarea,iframe,summary')&&e.checkVisibility()).map(([,i])=>i)")
        self.assertLessEqual(set(controls), reached)
