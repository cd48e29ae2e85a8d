"""Reads a roster in the format OneRoster 1.2 CSV. Names and mail addresses are not stored."""
import csv
import io
import secrets
import zipfile

from django.contrib.auth.models import User
from django.db import transaction

from .models import Class, School, Student

MAX_BYTES, MAX_ROWS = 64 << 20, 100_000
ALPHABET = "23456789ABCDEFGHJKMNPQRSTUVWXYZ"
COLUMNS = {"orgs.csv": {"sourcedId", "name", "type"}, "classes.csv": {"sourcedId", "title", "schoolSourcedId"},
           "users.csv": {"sourcedId", "enabledUser"}, "enrollments.csv": {"classSourcedId", "userSourcedId", "role"}}


class Unreadable(Exception):
    pass


def _table(packed, name):
    info = packed.getinfo(name)
    if info.file_size > MAX_BYTES:
        raise Unreadable(f"{name}: larger than {MAX_BYTES >> 20} MiB")
    with packed.open(info) as raw:
        data = raw.read(MAX_BYTES + 1)
    rows = csv.DictReader(io.StringIO(data.decode("utf-8-sig"), newline=""))
    missing = COLUMNS[name] - set(rows.fieldnames or ())
    if missing:
        raise Unreadable(f"{name}: no column {', '.join(sorted(missing))}")
    for number, row in enumerate(rows, 2):
        if number > MAX_ROWS:
            raise Unreadable(f"{name}: more than {MAX_ROWS} rows")
        row = {key: (value or "").strip() for key, value in row.items() if key and isinstance(value, (str, type(None)))}
        if any(len(row[key]) > 100 for key in COLUMNS[name]):
            raise Unreadable(f"{name}, line {number}: a value of more than 100 characters")
        if row.get("status", "active") in ("", "active"):
            yield row


def code(length=6):
    return "".join(secrets.choice(ALPHABET) for _ in range(length))


def account(identifier, people, is_staff=False, **more):
    """Returns a new user with a random name: a teacher (is_staff) or a student. Adds name and first password to `people`."""
    password = code(12)
    while User.objects.filter(username=(name := f"{'t' if is_staff else 's'}-{code()}")).exists():
        pass
    people.append({"identifier": identifier, "pseudonym": name, "password": password})
    return User.objects.create_user(name, password=password, is_staff=is_staff, **more)


def read(upload):
    """Stores schools, classes, students, teachers and who is in which class. Returns the new people's first passwords."""
    try:
        with zipfile.ZipFile(upload) as packed, transaction.atomic():
            return _store({name: list(_table(packed, name)) for name in COLUMNS})
    except (zipfile.BadZipFile, KeyError, UnicodeDecodeError, csv.Error, TypeError, RuntimeError, NotImplementedError, EOFError, AttributeError) as problem:
        raise Unreadable(f"not a OneRoster file: {problem}")


def _store(tables):
    schools = {row["sourcedId"]: School.objects.update_or_create(source_id=row["sourcedId"], defaults={"name": row["name"]})[0]
               for row in tables["orgs.csv"] if row["type"] == "school"}
    classes = {}
    for row in tables["classes.csv"]:
        if row["schoolSourcedId"] not in schools:
            raise Unreadable(f"classes.csv: class {row['sourcedId']} is of no school")
        classes[row["sourcedId"]], _ = Class.objects.update_or_create(
            source_id=row["sourcedId"], defaults={"name": row["title"], "school": schools[row["schoolSourcedId"]]})
    enabled = {row["sourcedId"]: row["enabledUser"].lower() != "false" for row in tables["users.csv"]}
    people, roles, rosters = [], {}, {key: ([], []) for key in classes}
    for row in tables["enrollments.csv"]:
        who, where = row["userSourcedId"], row["classSourcedId"]
        if who not in enabled or where not in classes:
            raise Unreadable(f"enrollments.csv: unknown user {who} or class {where}")
        if row["role"] in ("student", "teacher"):
            roles.setdefault(who, row["role"])
            rosters[where][row["role"] == "teacher"].append(who)
    known = {}
    for who, role in roles.items():
        if role == "student":
            student = Student.objects.filter(source_id=who).first()
            if not student:
                user = account(who, people)
                student = Student.objects.create(pseudonym=user.username, source_id=who, user=user)
            known[who], user = student, student.user
        else:
            user = User.objects.filter(last_name=who, is_staff=True).first()  # a teacher's sourcedId
            known[who] = user = user or account(who, people, is_staff=True, last_name=who)
        if user:
            user.is_active = enabled[who]
            user.save()
    for key, (students, teachers) in rosters.items():
        classes[key].students.set(known[who] for who in students if roles[who] == "student")
        classes[key].teachers.set(known[who] for who in teachers if roles[who] == "teacher")
    return people
