#!/usr/bin/env python3
"""Hands finished recordings of a folder in to the school's service. Works offline first: what could not be sent is
sent later. Needs only Python's own library.

usage: hand_in.py FOLDER [once]
TYPODONT_SCHOOL_ADDRESS is the service, TYPODONT_SCHOOL_TOKEN_FILE the file with the bench's token,
TYPODONT_SCHOOL_KEY_FILE that with its signing key: then each recording is signed by TYPODONT_SCHOOL_PROGRAM."""
import hashlib
import http.client
import json
import os
import pathlib
import subprocess
import sys
import time
import urllib.error
import urllib.request

CHUNK = 1 << 20
MIN_WAIT, MAX_WAIT = 2, 600  # s
KEY_FILE = os.environ.get("TYPODONT_SCHOOL_KEY_FILE")
PROGRAM = os.environ.get("TYPODONT_SCHOOL_PROGRAM", "typodont")
FINAL = ("waiting", "accepted", "refused")


def sha256(file):
    digest = hashlib.sha256()
    with open(file, "rb") as f:
        for block in iter(lambda: f.read(1 << 20), b""):
            digest.update(block)
    return digest.hexdigest()


class Later(Exception):
    """The service cannot take the session now."""


class Service:
    def __init__(self, address, token):
        self.address, self.token = address.rstrip("/"), token

    def ask(self, sha, chunk=None, **headers):
        """Returns status and answer; raises Later if there is none."""
        request = urllib.request.Request(f"{self.address}/api/hand-in/{sha}", chunk, {"Authorization": "Bearer " + self.token, **headers},
                                         method="PUT" if chunk is not None else "GET")
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, json.loads(answer.read(1 << 16))
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
        try:
            self.done = json.loads(self.list.read_text())
        except (OSError, ValueError):  # lost or damaged: the service knows what it has
            self.done = {}

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
                stamp = self.stamp(file)
                state, sha = service.send(file)
            except (Later, OSError, subprocess.SubprocessError) as reason:
                left += 1
                said(f"{file.name}: later ({reason})")
                continue
            self.done[str(file.relative_to(self.path))] = {"stamp": stamp, "sha256": sha, "state": state}
            part = self.list.with_suffix(".part")
            part.write_text(json.dumps(self.done))
            os.replace(part, self.list)
            said(f"{file.name}: handed in, {state}")
        return left


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["once"]) or not os.path.isdir(sys.argv[1]):
        sys.exit(__doc__)
    token = pathlib.Path(os.environ.get("TYPODONT_SCHOOL_TOKEN_FILE", os.path.expanduser("~/Typodont/school.token"))).read_text().strip()
    service, wait = Service(os.environ.get("TYPODONT_SCHOOL_ADDRESS", "http://localhost:8068"), token), MIN_WAIT
    while True:
        left = Folder(sys.argv[1]).hand_in(service)
        if sys.argv[2:] == ["once"]:
            sys.exit(1 if left else 0)
        wait = min(2 * wait, MAX_WAIT) if left else MIN_WAIT
        time.sleep(wait)


if __name__ == "__main__":
    main()
