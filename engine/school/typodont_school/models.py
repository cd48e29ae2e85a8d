"""What the school stores. People appear as pseudonyms; their names stay with the school."""
from django.contrib.auth.models import User
from django.db import models
from django.utils import timezone


class School(models.Model):
    name = models.CharField(max_length=100, unique=True)
    source_id = models.CharField(max_length=100, blank=True, db_index=True)  # OneRoster sourcedId


class Class(models.Model):
    school = models.ForeignKey(School, models.CASCADE)
    name = models.CharField(max_length=100)
    source_id = models.CharField(max_length=100, blank=True, db_index=True)
    teachers = models.ManyToManyField(User, related_name="classes", blank=True)


class Student(models.Model):
    pseudonym = models.CharField(max_length=40, unique=True)  # the bench's trainee
    source_id = models.CharField(max_length=100, blank=True, db_index=True)
    user = models.OneToOneField(User, models.SET_NULL, null=True, blank=True)
    classes = models.ManyToManyField(Class, related_name="students", blank=True)


class Bench(models.Model):
    school = models.ForeignKey(School, models.CASCADE)
    name = models.CharField(max_length=100)
    token_hash = models.CharField(max_length=64, unique=True)
    signing_key = models.CharField(max_length=64)  # of `typodont sign`, shared with the bench
    last_seen = models.DateTimeField(null=True)


class Exercise(models.Model):
    name = models.CharField(max_length=100, unique=True)
    scene = models.JSONField()
    files = models.JSONField()  # path in assets -> SHA-256

    def title(self, language):
        title = self.scene.get("task", {}).get("title", {})
        text = (title.get(language) or title.get("en") if isinstance(title, dict) else title) or self.name
        return f"{text} ({self.name})" if self.is_case else text

    @property
    def is_case(self):
        """Made from a seed; its tissue is a file of its own, not of the assets."""
        return f"{self.name}.vdb" in self.files


class Assignment(models.Model):
    group = models.ForeignKey(Class, models.CASCADE, related_name="assignments")
    exercise = models.ForeignKey(Exercise, models.CASCADE)
    opens = models.DateTimeField(default=timezone.now)
    due = models.DateTimeField()
    attempts = models.PositiveIntegerField(default=3)
    sealed = models.BooleanField(default=False)
    line_item = models.URLField(blank=True, max_length=500)  # LTI Assignment and Grade Services
    platform = models.ForeignKey("Platform", models.SET_NULL, null=True)


class Session(models.Model):
    WAITING, ACCEPTED, REFUSED = "waiting", "accepted", "refused"
    sha256 = models.CharField(max_length=64, primary_key=True)
    bench = models.ForeignKey(Bench, models.PROTECT)
    size = models.PositiveBigIntegerField()
    received = models.DateTimeField(default=timezone.now)
    bench_date = models.CharField(max_length=40, blank=True)  # the bench's clock may be wrong
    signature = models.CharField(max_length=300, blank=True)
    state = models.CharField(max_length=10, default=WAITING)
    reason = models.CharField(max_length=300, blank=True)
    student = models.ForeignKey(Student, models.CASCADE, null=True)
    exercise = models.ForeignKey(Exercise, models.PROTECT, null=True)
    assignment = models.ForeignKey(Assignment, models.SET_NULL, null=True)
    scene_name = models.CharField(max_length=100, blank=True)
    attempt = models.PositiveIntegerField(default=0)  # of this student at this exercise
    points = models.FloatField(null=True)
    passed = models.BooleanField(null=True)
    completion = models.FloatField(null=True)
    seconds = models.FloatField(default=0)
    truncated = models.BooleanField(default=False)
    force_hash = models.CharField(max_length=16, blank=True, db_index=True)  # of the first forces, or of few
    defects = models.JSONField(default=list)  # with their strokes, of `typodont report`
    program = models.CharField(max_length=60, blank=True)  # that gave the points

    class Meta:
        indexes = [models.Index(fields=["student", "exercise", "attempt"]), models.Index(fields=["student", "received"]),
                   models.Index(fields=["received"], condition=models.Q(state="waiting"), name="waiting_sessions")]


class Film(models.Model):
    """A film of a session that somebody asked for."""
    WAITING, MAKING, READY, FAILED = "waiting", "making", "ready", "failed"
    session = models.OneToOneField(Session, models.CASCADE, primary_key=True)
    asked = models.DateTimeField(default=timezone.now)
    asked_by = models.ForeignKey(User, models.SET_NULL, null=True)
    language = models.CharField(max_length=2, default="en")
    state = models.CharField(max_length=10, default=WAITING, db_index=True)
    reason = models.CharField(max_length=300, blank=True)
    size = models.PositiveBigIntegerField(default=0)


class ScoreItem(models.Model):
    session = models.ForeignKey(Session, models.CASCADE, related_name="items")
    name = models.CharField(max_length=60)
    value = models.FloatField(null=True)
    unit = models.CharField(max_length=20, blank=True)
    target = models.FloatField(null=True)
    points = models.FloatField()
    full = models.FloatField()
    critical = models.BooleanField(default=False)  # fails the session, whatever its points
    place = models.CharField(max_length=60, blank=True)  # of the largest deviation: part.wall side.lingual third.middle


class Rescore(models.Model):
    """Points that a later program gives."""
    session = models.ForeignKey(Session, models.CASCADE, related_name="rescores")
    program = models.CharField(max_length=60)
    at = models.DateTimeField(default=timezone.now)
    points = models.FloatField(null=True)
    passed = models.BooleanField(null=True)
    error = models.CharField(max_length=300, blank=True)

    class Meta:
        constraints = [models.UniqueConstraint(fields=["session", "program"], name="one_rescore_a_program")]

    @property
    def differs(self):
        return self.points is None or abs(self.points - self.session.points) > 1e-6 or self.passed != self.session.passed


class Remark(models.Model):
    session = models.ForeignKey(Session, models.CASCADE, related_name="remarks")
    author = models.ForeignKey(User, models.SET_NULL, null=True)
    written = models.DateTimeField(default=timezone.now)
    text = models.TextField(max_length=4000)
    at_s = models.FloatField(null=True)  # moment of the recording

    def row(self):
        """The remark in the form of SESSION.h5.remarks.json."""
        moment = {} if self.at_s is None else {"at_s": self.at_s}
        return {"author": self.author.username if self.author else "", "written": self.written.isoformat(), "text": self.text, **moment}


class ExamStart(models.Model):
    """A student's one start of a sealed exam. The seed stands in the scene that the bench records."""
    assignment = models.ForeignKey(Assignment, models.CASCADE)
    student = models.ForeignKey(Student, models.CASCADE)
    bench = models.ForeignKey(Bench, models.CASCADE)
    seed = models.CharField(max_length=32, unique=True)
    started = models.DateTimeField(default=timezone.now)
    announced_s = models.FloatField(default=0)  # what the bench said of its recording
    session = models.OneToOneField(Session, models.SET_NULL, null=True)

    class Meta:
        constraints = [models.UniqueConstraint(fields=["assignment", "student"], name="one_start_a_student")]


class SignInFailure(models.Model):
    key = models.CharField(max_length=200, db_index=True)
    at = models.DateTimeField(default=timezone.now, db_index=True)


class Platform(models.Model):
    """A learning system that launches this tool by LTI 1.3."""
    issuer = models.CharField(max_length=300)
    client_id = models.CharField(max_length=200)
    deployment = models.CharField(max_length=200)
    sign_in_url = models.URLField(max_length=500)
    token_url = models.URLField(max_length=500)
    keys = models.JSONField(default=dict)  # JSON Web Key Set

    class Meta:
        constraints = [models.UniqueConstraint(fields=["issuer", "client_id"], name="one_client_an_issuer")]


class Launch(models.Model):
    """State and nonce of a started launch; used once."""
    state = models.CharField(max_length=64, primary_key=True)
    nonce = models.CharField(max_length=64)
    platform = models.ForeignKey(Platform, models.CASCADE)
    started = models.DateTimeField(default=timezone.now)


class Identity(models.Model):
    """A person of a learning system, known here."""
    platform = models.ForeignKey(Platform, models.CASCADE)
    subject = models.CharField(max_length=255)
    user = models.ForeignKey(User, models.CASCADE)

    class Meta:
        constraints = [models.UniqueConstraint(fields=["platform", "subject"], name="one_user_a_subject")]


class Grade(models.Model):
    """A score that waits to be sent to a learning system."""
    session = models.OneToOneField(Session, models.CASCADE)
    subject = models.CharField(max_length=255)
    sent = models.DateTimeField(null=True)
    tries = models.PositiveIntegerField(default=0)
    error = models.CharField(max_length=300, blank=True)
