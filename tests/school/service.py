"""The service as a process, started by its one command, and what a browser and a bench ask of it."""
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request

from django.test import SimpleTestCase

from room import record
from typodont_school import intake


class ServiceTest(SimpleTestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"http://127.0.0.1:{free.getsockname()[1]}"
        self.environment = {**os.environ, "PYTHONPATH": str(intake.settings.TREE / "engine/school"), "PYTHONUNBUFFERED": "1",
                            "TYPODONT_SCHOOL_DATA": str(self.folder / "data"), "TYPODONT_SCHOOL_ADDRESS": self.address,
                            "TYPODONT_SCHOOL_TOKEN_FILE": str(self.folder / "token")}
        self.browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())

    def start(self):
        """Returns the process and what it said until it listens."""
        process = subprocess.Popen([sys.executable, "-m", "typodont_school"], env=self.environment, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        said = ""
        while "typodont-school:" not in said:
            line = process.stdout.readline()
            self.assertTrue(line, "ended: " + said)
            said += line
        while True:
            try:
                self.get("/sign-in")
                return process, said
            except OSError:
                self.assertIsNone(process.poll())

    def sign_in(self, said):
        self.post("/sign-in", "/sign-in", username="admin", password=re.search(r"password (\S+),", said)[1])

    def add_bench(self, name="bench 1"):
        """Returns the bench's token and its signing key."""
        return re.findall(r"<pre[^>]*>(\S+)</pre>", self.post("/administration/bench", "/administration", name=name))

    def get(self, path, **form):
        data = urllib.parse.urlencode(form).encode() if form else None
        with self.browser.open(self.address + path, data) as answer:
            return answer.read().decode()

    def post(self, path, page, **form):
        token = re.search(r'csrfmiddlewaretoken" value="(\w+)"', self.get(page))[1]
        return self.get(path, csrfmiddlewaretoken=token, **form)

    def start_with_bench(self, recordings):
        """Returns the process, and the command that hands in these recordings."""
        server, said = self.start()
        self.sign_in(said)
        (self.folder / "token").write_text(self.add_bench()[0])
        folder = self.folder / "recordings"
        folder.mkdir()
        for number in range(recordings):
            shutil.copy(record(f"hand{number}", "nobody", number), folder)
        return server, [sys.executable, intake.settings.TREE / "engine/school/typodont_school/hand_in.py", folder, "once"]

    def wait_for_checks(self, server, count):
        while (page := self.get("/administration")).count("state accepted") < count:  # checked by the service itself
            self.assertNotIn("state refused", page)
            self.assertIsNone(server.poll())
            time.sleep(0.2)
