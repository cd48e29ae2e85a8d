"""Reads a recording with the program `typodont`, in a child process with limits. An upload is hostile until then."""
import functools
import json
import os
import pathlib
import resource
import shutil
import subprocess

from django.conf import settings

from .hand_in import sha256

LIMITS = {resource.RLIMIT_AS: 8 << 30, resource.RLIMIT_CPU: 600, resource.RLIMIT_FSIZE: 512 << 20, resource.RLIMIT_CORE: 0}
FILM_LIMITS = {resource.RLIMIT_CPU: 3600, resource.RLIMIT_FSIZE: 256 << 20}
FILM_TIME, FILM_NICE = 2 * 3600, 10  # s, by the clock; low priority
MAX_FRAMES, MAX_FPS = 2400, 15  # a frame takes half a second of a processor
MAX_REASON = 300


class Refused(Exception):
    """The recording is not what it claims to be; the text says why."""


def run(*command, limits={}, seconds=900, nice=0):
    """Returns exit status, output and the last line of messages."""
    def limit():
        os.nice(nice)
        for resource_name, value in {**LIMITS, **limits}.items():
            resource.setrlimit(resource_name, (value, value))

    try:
        # The child ends with the service, so that a restarted service runs it once.
        done = subprocess.run(["setpriv", "--pdeathsig", "KILL", *(str(part) for part in command)], capture_output=True, timeout=seconds, env=environment(),
                              stdin=subprocess.DEVNULL, preexec_fn=limit, start_new_session=True)
    except subprocess.TimeoutExpired:
        raise Refused("reading took too long")
    messages = done.stderr.decode(errors="replace").strip().splitlines() or [""]
    return done.returncode, done.stdout, messages[-1][:MAX_REASON]


def environment():
    keep = {name: value for name, value in os.environ.items() if name.startswith("TYPODONT_") and not name.startswith("TYPODONT_SCHOOL_")}
    return {"PATH": "/usr/bin:/bin", "LANG": "C.UTF-8", "HOME": str(settings.DATA), **keep,
            "TYPODONT_HOME": str(settings.DATA / "home"), "TYPODONT_CACHE": str(settings.DATA / "cache"),
            "TYPODONT_FILES": str(settings.DATA / "cases")}


def typodont(*arguments, fine=(0,)):
    status, output, message = run(settings.PROGRAM, *arguments)
    if status not in fine:
        raise Refused(message or f"the reader ended with status {status}")
    return output


def check(recording, key=None):
    """Replays the recording bit for bit. Returns the program's summary."""
    summary = json.loads(typodont("replay", recording, "--check", "--json", *(("--key", key) if key else ()), fine=(0, 1)) or "null")
    if summary is None:
        raise Refused("no valid signature" if key else "cannot be replayed")
    return summary


def score(recording, page):
    """Returns the score that the recording's own cuts give; writes the program's page, whose file LANGUAGE.html names the language."""
    return json.loads(typodont("report", recording, "--out", page, "--json", "--language", page.stem))


def film(recording, out, seconds, rig, language):
    """Writes a film of a recording of this duration, with low priority."""
    fps, speed = min(MAX_FPS, max(1, MAX_FRAMES / max(seconds, 1))), max(1, seconds / MAX_FRAMES)
    status, _, message = run(settings.PROGRAM, "replay", recording, "--film", out, "--fps", f"{fps:.3f}", "--speed", f"{speed:.3f}",
                             "--rig", rig, "--language", language, limits=FILM_LIMITS, seconds=FILM_TIME, nice=FILM_NICE)
    if status or not out.exists():
        raise Refused(message or f"the film ended with status {status}")


def header(recording):
    """Returns scene, files, trainee and date. Only for a recording that the program has read."""
    status, output, message = run("/usr/bin/python3", "-I", pathlib.Path(__file__).with_name("header.py"), recording)
    if status:
        raise Refused(message)
    return json.loads(output)


@functools.cache
def version():
    """Returns the program's version, and the start of its file's SHA-256, which differs between builds."""
    return f"{typodont('--version').decode().strip()} ({sha256(shutil.which(settings.PROGRAM))[:12]})"


@functools.cache
def families():
    """Returns the names of the families of cases."""
    return [line.partition(":")[0] for line in typodont("case", "--list").decode().splitlines()]


def make_case(out, family, seed, difficulty):
    """Writes a case's scene, and its tissue beside it."""
    typodont("case", family, "--seed", seed, "--difficulty", difficulty, "--out", out)
