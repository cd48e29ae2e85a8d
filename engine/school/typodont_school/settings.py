"""Settings from the environment; docs/school.md lists the variables."""
import os
import pathlib
import secrets
from urllib.parse import urlsplit


def setting(name, default=""):
    return os.environ.get("TYPODONT_SCHOOL_" + name, default)


HERE = pathlib.Path(__file__).resolve().parent
# In the source tree engine/school/typodont_school, installed share/typodont/school/typodont_school.
TREE = next((folder for folder in HERE.parents[1:3] if (folder / "assets/scenes").is_dir()), HERE.parents[2])
TEXTS = next(file for file in (HERE / "report.json", TREE / "engine/session/texts/report.json") if file.exists())
DATA = pathlib.Path(setting("DATA", os.path.expanduser("~/Typodont/school"))).resolve()
DATA.mkdir(parents=True, exist_ok=True, mode=0o700)
PROGRAM = setting("PROGRAM", next((str(file) for file in (TREE / "build/release/typodont", TREE.parents[1] / "bin/typodont")
                                   if file.exists()), "typodont"))
SCENES = pathlib.Path(os.environ.get("TYPODONT_ASSETS", TREE / "assets")) / "scenes"
MAX_SESSION_BYTES = int(setting("MAX_SESSION_MIB", "256")) << 20
MAX_FILMS_BYTES = int(setting("MAX_FILMS_GIB", "20")) << 30
MIN_FREE_BYTES = 64 << 20
ADDRESS = setting("ADDRESS", "http://localhost:8068")  # as people's browsers reach the service


def _secret():
    """Returns the key that signs cookies. Made once, readable by this account only."""
    file = DATA / "secret.key"
    try:
        with open(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as out:
            out.write(secrets.token_hex(32))
    except FileExistsError:
        pass
    return file.read_text()


def _database():
    url = urlsplit(setting("DATABASE"))
    if url.scheme == "postgresql":
        return {"ENGINE": "django.db.backends.postgresql", "NAME": url.path.lstrip("/"), "USER": url.username or "",
                "PASSWORD": url.password or "", "HOST": url.hostname or "", "PORT": url.port or ""}
    return {"ENGINE": "django.db.backends.sqlite3", "NAME": DATA / "school.sqlite", "OPTIONS": {"timeout": 30}}


SECRET_KEY = _secret()
DEBUG = False
HTTPS = ADDRESS.startswith("https:")
ALLOWED_HOSTS = [urlsplit(ADDRESS).hostname] + setting("HOSTS", "localhost 127.0.0.1").split()
ROOT_URLCONF = "typodont_school.urls"
INSTALLED_APPS = ["django.contrib.auth", "django.contrib.contenttypes", "django.contrib.sessions", "typodont_school"]
MIDDLEWARE = [
    "django.middleware.security.SecurityMiddleware",
    "whitenoise.middleware.WhiteNoiseMiddleware",
    "django.contrib.sessions.middleware.SessionMiddleware",
    "django.middleware.common.CommonMiddleware",
    "django.middleware.csrf.CsrfViewMiddleware",
    "django.contrib.auth.middleware.AuthenticationMiddleware",
    "django.middleware.clickjacking.XFrameOptionsMiddleware",
    "typodont_school.access.content_policy",
]
TEMPLATES = [{"BACKEND": "django.template.backends.django.DjangoTemplates", "APP_DIRS": True, "OPTIONS": {
    "context_processors": ["django.template.context_processors.request", "django.contrib.auth.context_processors.auth",
                           "typodont_school.access.frame"],
    "builtins": ["typodont_school.templatetags.words"]}}]
DATABASES = {"default": _database()}
DEFAULT_AUTO_FIELD = "django.db.models.BigAutoField"
AUTH_PASSWORD_VALIDATORS = [{"NAME": "django.contrib.auth.password_validation." + name, "OPTIONS": options} for name, options in
                            (("MinimumLengthValidator", {"min_length": 10}), ("CommonPasswordValidator", {}))]
LOGIN_URL = "sign_in"
STATIC_URL = "/static/"
WHITENOISE_USE_FINDERS = True
WHITENOISE_AUTOREFRESH = False
STATICFILES_DIRS = [HERE / "static"]
STATICFILES_FINDERS = ["django.contrib.staticfiles.finders.FileSystemFinder"]
USE_TZ = True
TIME_ZONE = setting("TIME_ZONE", "UTC")
SESSION_COOKIE_AGE = 12 * 3600
SESSION_COOKIE_HTTPONLY = CSRF_COOKIE_HTTPONLY = True
SESSION_COOKIE_SECURE = CSRF_COOKIE_SECURE = HTTPS
SECURE_PROXY_SSL_HEADER = ("HTTP_X_FORWARDED_PROTO", "https") if HTTPS else None
SECURE_HSTS_SECONDS = 31536000 if HTTPS else 0
SECURE_REFERRER_POLICY = "same-origin"
DATA_UPLOAD_MAX_MEMORY_SIZE = 8 << 20
LOGGING = {"version": 1, "disable_existing_loggers": False, "handlers": {"console": {"class": "logging.StreamHandler"}},
           "root": {"handlers": ["console"], "level": "WARNING"}}
