"""Who may see what. Every page gets its objects from here and nowhere else."""
import functools
from datetime import timedelta

from django.contrib import auth
from django.contrib.auth.views import redirect_to_login
from django.core.exceptions import PermissionDenied
from django.http import HttpResponseNotAllowed
from django.utils import timezone

from . import words
from .models import Assignment, Class, Exercise, Session, SignInFailure, Student

STUDENT, TEACHER, ADMIN = "student", "teacher", "admin"
STAFF = (TEACHER, ADMIN)
ALL = (STUDENT, TEACHER, ADMIN)
MAX_FAILURES, FAILURE_WINDOW = 8, timedelta(minutes=15)


def known(request, name):
    """Returns the user with this name and the request's password, or an error and its status."""
    name = name[:150]
    keys = ["name " + name.lower(), "from " + request.META.get("REMOTE_ADDR", "")]
    recent = SignInFailure.objects.filter(at__gt=timezone.now() - FAILURE_WINDOW)
    limits = (MAX_FAILURES, 10 * MAX_FAILURES)  # a room of benches shares one address
    if any(recent.filter(key=key).count() >= limit for key, limit in zip(keys, limits)):
        return None, "too_many", 429
    user = auth.authenticate(request, username=name, password=request.POST.get("password", ""))
    if user:
        return user, None, 200
    SignInFailure.objects.filter(at__lt=timezone.now() - FAILURE_WINDOW).delete()
    SignInFailure.objects.bulk_create(SignInFailure(key=key) for key in keys)
    return None, "wrong", 403


def role(user):
    if not user.is_authenticated or not user.is_active:
        return None
    if user.is_superuser:
        return ADMIN
    if user.is_staff:
        return TEACHER
    return STUDENT if hasattr(user, "student") else None


def visible(user, model):
    """Returns the objects of a model that the user may see."""
    who, everything, nothing = role(user), model.objects.all(), model.objects.none()
    if who == ADMIN or (model is Exercise and who):
        return everything
    if who == TEACHER:
        of_class = {Class: "teachers", Student: "classes__teachers", Assignment: "group__teachers",
                    Session: "student__classes__teachers"}.get(model)
    elif who == STUDENT:
        of_class = {Student: "user", Assignment: "group__students__user", Session: "student__user"}.get(model)
    else:
        return nothing
    return everything.filter(**{of_class: user}).distinct() if of_class else nothing


def get(user, model, key):
    """Returns one object. Absent and forbidden look alike."""
    found = visible(user, model).filter(pk=key).first()
    if found is None:
        raise PermissionDenied
    return found


def page(*roles, methods="GET"):
    """Marks a view as a page for these roles. Signed-out people are asked to sign in, whatever the address."""
    def mark(view):
        @functools.wraps(view)
        def checked(request, *args, **kwargs):
            who = role(request.user)
            if who is None:
                return redirect_to_login(request.get_full_path())
            if who not in roles:
                raise PermissionDenied
            if request.method not in methods.split():
                return HttpResponseNotAllowed(methods.split())
            request.role = who
            return view(request, *args, **kwargs)
        checked.roles, checked.methods = roles, methods.split()
        return checked
    return mark


def public(view):
    """Marks a view that checks by itself: sign-in, a bench's token, a platform's signature."""
    view.roles = None
    return view


def frame(request):
    """What every template knows."""
    return {"language": words.language_of(request), "role": role(request.user), "languages": words.LANGUAGES}


def content_policy(get_response):
    """Nothing but this service's own files, unless a view has set a stricter policy."""
    def middleware(request):
        response = get_response(request)
        response.setdefault("Content-Security-Policy", "default-src 'self'; img-src 'self' data:; object-src 'none'; "
                            "base-uri 'none'; frame-ancestors 'none'; form-action 'self'")
        response.setdefault("Cache-Control", "private, no-store")
        return response
    return middleware
