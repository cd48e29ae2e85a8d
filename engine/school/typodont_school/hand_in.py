#!/usr/bin/env python3
"""Hands finished recordings of a folder in to the school's service. Works offline first: what could not be sent is
sent later. Needs only Python's own library.

usage: hand_in.py FOLDER [once]
       hand_in.py window      one request of the operator's window: JSON in, lines of JSON out, the last is the answer
TYPODONT_SCHOOL_ADDRESS is the service, TYPODONT_SCHOOL_TOKEN_FILE the file with the bench's token,
TYPODONT_SCHOOL_KEY_FILE that with its signing key: then each recording is signed by TYPODONT_SCHOOL_PROGRAM.
What the environment does not set is read from school.env in the user's folder."""
import hashlib
import http.client
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
import zipfile

CHUNK = 1 << 20
MIN_WAIT, MAX_WAIT = 2, 600  # s
FINAL = ("waiting", "accepted", "refused")
WISH = ".to-hand-in"  # ending of the empty file that the window puts beside a recording
CHECK_TIME = 300  # s, in which the window waits for the service's checks
MAX_FILES = 1 << 30  # bytes of an exercise's files
HOME = pathlib.Path(os.environ.get("TYPODONT_HOME") or os.path.expanduser("~/Typodont"))


def setting(name, default=""):
    """Returns a setting of the environment, or of school.env in the form of systemd."""
    if "TYPODONT_SCHOOL_" + name in os.environ:
        return os.environ["TYPODONT_SCHOOL_" + name]
    try:
        lines = (HOME / "school.env").read_text().splitlines()
    except OSError:
        lines = []
    found = [value for key, _, value in (line.strip().partition("=") for line in lines) if key == "TYPODONT_SCHOOL_" + name]
    return found[-1].strip("\"'") if found else default


KEY_FILE = setting("KEY_FILE")
PROGRAM = setting("PROGRAM", "typodont")


def sha256(file):
    digest = hashlib.sha256()
    with open(file, "rb") as f:
        for block in iter(lambda: f.read(1 << 20), b""):
            digest.update(block)
    return digest.hexdigest()


class Later(Exception):
    """The service cannot take the session now."""


class NoRedirect(urllib.request.HTTPRedirectHandler):
    """Tokens and passwords go to the service's own address only."""
    def redirect_request(self, *_):
        return None


class Service:
    def __init__(self, address, token):
        self.address, self.token = address.rstrip("/"), token

    @classmethod
    def of_settings(cls):
        file = pathlib.Path(setting("TOKEN_FILE", str(HOME / "school.token")))
        return cls(setting("ADDRESS", "http://localhost:8068"), file.read_text().strip())

    def ask(self, sha, chunk=None, **headers):
        """Returns status and answer about a session; raises Later if there is none."""
        return self.request("hand-in/" + sha, chunk, method="PUT" if chunk is not None else "GET", **headers)

    def request(self, path, data=None, method=None, read=json.loads, most=1 << 22, **headers):
        request = urllib.request.Request(f"{self.address}/api/{path}", data, {"Authorization": "Bearer " + self.token, **headers}, method=method)
        try:
            with urllib.request.build_opener(NoRedirect).open(request, timeout=60) as answer:
                return answer.status, read(answer.read(most))
        except urllib.error.HTTPError as error:
            try:
                return error.code, json.loads(error.read(1 << 16))
            except (ValueError, OSError, http.client.HTTPException):
                raise Later(f"status {error.code}")
        except (OSError, ValueError, http.client.HTTPException) as error:
            raise Later(str(error))

    def send(self, file):
        """Sends what the service does not have yet. Returns its state of the session and the hash."""
        sha, total = sha256(file), os.path.getsize(file)
        signature = file.with_name(file.name + ".sig")
        if KEY_FILE and not signature.exists():
            subprocess.run([PROGRAM, "sign", "--key", KEY_FILE, file], check=True, stdout=subprocess.DEVNULL)
        extra = {"X-Signature": signature.read_text().strip()} if signature.exists() else {}
        status, answer = self.ask(sha, **extra)
        with open(file, "rb") as f:
            while status in (200, 409):
                if answer.get("state") in FINAL:
                    return answer["state"], sha
                if "received" not in answer:
                    raise Later(answer.get("error", ""))
                first = answer["received"]
                f.seek(first)
                chunk = f.read(CHUNK)
                if not chunk:  # the service has more bytes than the file: it was shortened meanwhile
                    raise Later("the file has changed")
                status, answer = self.ask(sha, chunk, **extra, **{"Content-Range": f"bytes {first}-{first + len(chunk) - 1}/{total}"})
        if status in (413,):
            return "refused", sha
        raise Later(f"{answer.get('error', '')} (status {status})")


class Folder:
    """A folder of recordings, and the list of those that the service has."""
    def __init__(self, path):
        self.path = pathlib.Path(path)
        self.list = self.path / ".handed-in.json"
        self.done = self.read()

    def read(self):
        try:
            return json.loads(self.list.read_text())
        except (OSError, ValueError):  # lost or damaged: the service knows what it has
            return {}

    def waiting(self):
        for file in sorted(self.path.rglob("*.h5")):
            if file.with_name(file.name + ".journal").exists():  # still recording, or in need of `typodont repair`
                continue
            if self.done.get(str(file.relative_to(self.path)), {}).get("stamp") != self.stamp(file):
                yield file

    @staticmethod
    def stamp(file):
        about = file.stat()
        return [about.st_size, about.st_mtime_ns]

    def hand_in(self, service, said=print):
        """Tries every waiting recording; returns how many are left."""
        left = 0
        for file in self.waiting():
            try:
                state, _ = self.send(service, file)
            except (Later, OSError, subprocess.SubprocessError) as reason:
                left += 1
                said(f"{file.name}: later ({reason})")
                continue
            said(f"{file.name}: handed in, {state}")
        return left

    def send(self, service, file):
        """Sends a recording and remembers what became of it. Returns its state and hash."""
        stamp = self.stamp(file)
        state, sha = service.send(file)
        self.mark(file, stamp=stamp, sha256=sha, state=state)
        return state, sha

    def mark(self, file, **entry):
        self.done = self.read()  # window and watch share the list
        self.done[str(file.relative_to(self.path))] = entry
        part = self.list.with_suffix(f".{os.getpid()}.part")
        part.write_text(json.dumps(self.done))
        os.replace(part, self.list)
        file.with_name(file.name + WISH).unlink(missing_ok=True)

    def wanted(self):
        """Recordings that the window was to hand in and could not."""
        for wish in sorted(self.path.rglob("*.h5" + WISH)):
            file = wish.with_name(wish.name.removesuffix(WISH))
            if file in self.waiting():
                yield file
            elif not file.with_name(file.name + ".journal").exists():  # sent by the watch, or deleted
                wish.unlink()


# Requests of the operator's window.

ERRORS = ("wrong", "no_student", "too_many", "expired", "no_bench", "not_open")  # codes of the service


class Refusal(Exception):
    """The code of a sentence that the window shows."""


def say(**row):
    print(json.dumps(row), flush=True)


def answered(status, answer):
    if status == 200:
        return answer
    code = answer.get("code", "") if isinstance(answer, dict) else ""
    raise Refusal(code if code in ERRORS else "away")


def sign_in(service, asked):
    form = urllib.parse.urlencode({"name": asked["name"], "password": asked["password"]}).encode()
    return answered(*service.request("sign-in", form))


def student(asked):
    return {"X-Student": asked["token"], "Accept-Language": asked["language"]}


def me(service, asked):
    return answered(*service.request("me", **student(asked)))


def take(service, asked):
    """Puts the files of an assigned exercise into the folder of scenes. Starts a sealed exam."""
    number, folder = int(asked["number"]), pathlib.Path(asked["folder"])
    if asked["sealed"]:
        answered(*service.request(f"exam/{number}", urllib.parse.urlencode({"student": asked["student"]}).encode()))
    packed = answered(*service.request(f"assignment/{number}/files.zip", read=lambda data: zipfile.ZipFile(io.BytesIO(data)), most=MAX_FILES, **student(asked)))
    folder.mkdir(parents=True, exist_ok=True)
    scene = None
    for info in sorted(packed.infolist(), key=lambda info: info.filename.endswith(".json")):  # the scene after its tissue
        if not re.fullmatch(r"\w[\w.-]*\.(json|vdb)", info.filename) or info.file_size > MAX_FILES:
            raise Refusal("away")
        part = folder / (info.filename + ".part")
        part.write_bytes(packed.read(info))
        os.replace(part, folder / info.filename)
        scene = folder / info.filename
    return {"scene": str(scene)}


def announce(service, asked):
    """Tells how much of an exam is recorded."""
    return answered(*service.request("exam/progress", urllib.parse.urlencode({"seed": asked["exam"], "seconds": asked["seconds"]}).encode()))


def hand_in(service, asked):
    """Hands one recording in and waits for its checks. Without the service, the recording is sent later."""
    folder, file = Folder(asked["folder"]), pathlib.Path(asked["file"])
    say(stage="sending")
    try:
        state, sha = folder.send(service, file)
    except Later:
        raise Refusal("later")
    say(stage="checking")
    until = time.monotonic() + CHECK_TIME
    while state == "waiting" and time.monotonic() < until:
        time.sleep(2)
        try:
            state = service.ask(sha)[1].get("state", state)
        except Later:
            break
    return {"state": state}


def send_wanted(service, asked):
    """Sends what an earlier window could not."""
    folder, sent = Folder(asked["folder"]), 0
    files = list(folder.wanted())
    for file in files:
        try:
            folder.send(service, file)
        except (Later, OSError):
            break
        sent += 1
    return {"sent": sent, "left": len(files) - sent}


REQUESTS = {"sign_in": sign_in, "me": me, "take": take, "announce": announce, "hand_in": hand_in, "send_wanted": send_wanted}


def window():
    global PROGRAM
    asked = json.loads(sys.stdin.read())
    PROGRAM = setting("PROGRAM", asked.get("program", PROGRAM))
    try:
        say(**REQUESTS[asked["do"]](Service.of_settings(), asked))
    except Refusal as refusal:
        say(error=str(refusal))
    except Later:
        say(error="away")
    except (OSError, ValueError, KeyError, subprocess.SubprocessError, zipfile.BadZipFile) as problem:
        say(error="failed", detail=str(problem))


def main():
    if sys.argv[1:] == ["window"]:
        return window()
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["once"]) or not os.path.isdir(sys.argv[1]):
        sys.exit(__doc__)
    service, wait = Service.of_settings(), MIN_WAIT
    while True:
        left = Folder(sys.argv[1]).hand_in(service)
        if sys.argv[2:] == ["once"]:
            sys.exit(1 if left else 0)
        wait = min(2 * wait, MAX_WAIT) if left else MIN_WAIT
        time.sleep(wait)


if __name__ == "__main__":
    main()
