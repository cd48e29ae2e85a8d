"""Starts the service: python3 -m typodont_school [serve]. Other commands: migrate, backup FOLDER, rescore [DASK]."""
import hashlib
import json
import os
import pathlib
import secrets
import sys

os.environ.setdefault("DJANGO_SETTINGS_MODULE", "typodont_school.settings")


def register_exercises(scenes):
    """Makes every shipped scene with a task an exercise. A changed scene becomes the exercise's new content."""
    from typodont_school.models import Exercise
    for file in sorted(scenes.glob("*.json")):
        scene = json.loads(file.read_text())
        if "task" not in scene:
            continue
        paths = [scene.get("tissue", {}).get("volume")]
        files = {path: hashlib.sha256((scenes.parent / path).read_bytes()).hexdigest() for path in paths if path and (scenes.parent / path).exists()}
        Exercise.objects.update_or_create(name=scene.get("name", file.stem), defaults={"scene": scene, "files": files})


def set_up():
    try:
        import django
        import cryptography, h5py, jwt, waitress, whitenoise  # noqa: F401
    except ImportError as missing:
        sys.exit(f"{missing}; sudo apt install python3-django python3-waitress python3-whitenoise python3-jwt python3-cryptography python3-h5py")
    from django.conf import settings
    from django.core.management import call_command
    django.setup()
    call_command("migrate", verbosity=0)
    from django.contrib.auth.models import User
    from typodont_school.models import School
    register_exercises(settings.SCENES)
    if not School.objects.exists():
        School.objects.create(name="School")
    if not User.objects.filter(is_superuser=True).exists():
        password = secrets.token_urlsafe(12)
        User.objects.create_superuser("admin", password=password)
        print(f"first start: sign in as admin with the password {password}, then change it", flush=True)


def serve():
    from urllib.parse import urlsplit

    import waitress
    from django.conf import settings
    from typodont_school import films, intake
    from typodont_school.wsgi import application
    if not os.access(settings.PROGRAM, os.X_OK):
        sys.exit(f"{settings.PROGRAM}: no such program; ./run build makes it, TYPODONT_SCHOOL_PROGRAM names another")
    port = None if settings.HTTPS else urlsplit(settings.ADDRESS).port  # of https, the proxy's
    listen = os.environ.get("TYPODONT_SCHOOL_LISTEN", f"127.0.0.1:{port or 8068}")
    proxy = {"trusted_proxy": "127.0.0.1", "trusted_proxy_headers": {"x-forwarded-for", "x-forwarded-proto"},
             "clear_untrusted_proxy_headers": True} if settings.HTTPS else {}
    try:
        server = waitress.create_server(application, listen=listen, threads=8, ident=None, max_request_body_size=80 << 20, **proxy)
    except (OSError, ValueError) as problem:
        sys.exit(f"cannot listen at {listen}: {problem}; TYPODONT_SCHOOL_LISTEN names another address")
    intake.worker.start()
    films.maker.start()
    print(f"typodont-school: {settings.ADDRESS} (data in {settings.DATA})", flush=True)
    server.run()


def back_up(folder):
    import sqlite3

    import django
    django.setup()
    from typodont_school import backup
    try:
        print(f"{backup.back_up(pathlib.Path(folder).resolve())} new recordings")
    except (backup.Unusable, OSError, sqlite3.Error) as problem:
        sys.exit(f"no backup: {problem}")


def rescore(scheduler=None):
    set_up()
    from typodont_school import rescoring
    try:
        print(f"{rescoring.rescore_all(scheduler)} sessions scored again")
    except rescoring.NoDoor as problem:
        sys.exit(f"{problem}; ./run library and docs/doors/python.md install the Python package of typodont")


if __name__ == "__main__":
    match sys.argv[1:]:
        case [] | ["serve"]:
            set_up()
            serve()
        case ["migrate"]:
            set_up()
        case ["backup", folder]:
            back_up(folder)
        case ["rescore", *scheduler] if len(scheduler) < 2:
            rescore(*scheduler)
        case _:
            sys.exit("usage: python3 -m typodont_school [serve | migrate | backup FOLDER | rescore [DASK-SCHEDULER]]")
