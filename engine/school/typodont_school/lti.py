"""LTI 1.3: launches from a learning system, and scores back to it (Assignment and Grade Services)."""
import json
import secrets
import time
import urllib.error
import urllib.parse
import urllib.request
from datetime import timedelta

import jwt
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import rsa
from django.conf import settings
from django.contrib import auth
from django.contrib.auth.models import User
from django.core.exceptions import PermissionDenied
from django.db import transaction
from django.db.models import Q
from django.http import HttpResponseRedirect, JsonResponse
from django.shortcuts import redirect
from django.utils import timezone
from django.views.decorators.csrf import csrf_exempt

from .access import public
from .models import Assignment, Class, Grade, Identity, Launch, Platform, Session, Student

CLAIM = "https://purl.imsglobal.org/spec/lti/claim/"
AGS = "https://purl.imsglobal.org/spec/lti-ags/claim/endpoint"
SCORE_SCOPE = "https://purl.imsglobal.org/spec/lti-ags/scope/score"
CLOCK_SKEW = 60  # s
LAUNCH_TIME = timedelta(minutes=10)
MAX_TRIES = 20
ROLE = "http://purl.imsglobal.org/vocab/lis/v2/membership#"


def own_key():
    """Returns this tool's private key; made once."""
    file = settings.DATA / "lti.pem"
    if not file.exists():
        key = rsa.generate_private_key(public_exponent=65537, key_size=2048)
        part = settings.DATA / f"lti.{secrets.token_hex(4)}"
        part.touch(mode=0o600)
        part.write_bytes(key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()))
        part.replace(file)
    return serialization.load_pem_private_key(file.read_bytes(), None)


@public
def keys(request):
    key = json.loads(jwt.algorithms.RSAAlgorithm.to_jwk(own_key().public_key()))
    return JsonResponse({"keys": [{**key, "kid": "school", "use": "sig", "alg": "RS256"}]})


@public
@csrf_exempt  # from the platform's page; state and nonce follow
def sign_in(request):
    """First step: the platform names itself, the browser goes back to it with a state and a nonce."""
    given = request.POST if request.method == "POST" else request.GET
    platform = Platform.objects.filter(issuer=given.get("iss", ""))
    if given.get("client_id"):
        platform = platform.filter(client_id=given["client_id"])
    platform = platform.first()
    if platform is None:
        raise PermissionDenied
    Launch.objects.filter(started__lt=timezone.now() - LAUNCH_TIME).delete()
    launch = Launch.objects.create(state=secrets.token_urlsafe(32), nonce=secrets.token_urlsafe(32), platform=platform)
    query = {"scope": "openid", "response_type": "id_token", "response_mode": "form_post", "prompt": "none", "client_id": platform.client_id,
             "redirect_uri": settings.ADDRESS + "/lti/launch", "state": launch.state, "nonce": launch.nonce,
             "login_hint": given.get("login_hint", ""), "lti_message_hint": given.get("lti_message_hint", "")}
    answer = HttpResponseRedirect(platform.sign_in_url + ("&" if "?" in platform.sign_in_url else "?") + urllib.parse.urlencode(query))
    answer.set_cookie("lti_state", launch.state, max_age=600, httponly=True, secure=settings.HTTPS, samesite="None" if settings.HTTPS else None)
    return answer


def verified(token, launch):
    """Returns the claims of a launch that the platform has signed for this tool, now, once."""
    platform = launch.platform
    head = jwt.get_unverified_header(token)
    key = next((k for k in platform.keys.get("keys", []) if k.get("kid") == head.get("kid") and k.get("kty") == "RSA"), None)
    if key is None:
        raise jwt.InvalidTokenError("unknown key")
    claims = jwt.decode(token, jwt.algorithms.RSAAlgorithm.from_jwk(json.dumps(key)), algorithms=["RS256"], audience=platform.client_id,
                        issuer=platform.issuer, leeway=CLOCK_SKEW, options={"require": ["exp", "iat", "iss", "aud", "sub", "nonce"]})
    audience = claims["aud"] if isinstance(claims["aud"], list) else [claims["aud"]]
    if len(audience) > 1 and claims.get("azp") != platform.client_id:
        raise jwt.InvalidTokenError("for another client")
    if claims["iat"] > time.time() + CLOCK_SKEW:
        raise jwt.InvalidTokenError("from the future")
    if not secrets.compare_digest(str(claims["nonce"]), launch.nonce):
        raise jwt.InvalidTokenError("another nonce")
    wanted = {CLAIM + "version": "1.3.0", CLAIM + "message_type": "LtiResourceLinkRequest", CLAIM + "deployment_id": platform.deployment}
    if any(claims.get(key) != value for key, value in wanted.items()):
        raise jwt.InvalidTokenError("another kind of launch")
    return claims


@public
@csrf_exempt  # posted by the platform's page; the state is the guard
def launch(request):
    state = request.POST.get("state", "")
    with transaction.atomic():
        started = Launch.objects.select_related("platform").filter(state=state, started__gt=timezone.now() - LAUNCH_TIME).first()
        if not started or request.COOKIES.get("lti_state") != state or not Launch.objects.filter(pk=state).delete()[0]:
            raise PermissionDenied
    try:
        claims = verified(request.POST.get("id_token", ""), started)
    except (jwt.InvalidTokenError, ValueError, TypeError, KeyError):
        raise PermissionDenied
    user, group = person(started.platform, claims)
    remember_line_item(started.platform, claims, group)
    auth.login(request, user, "django.contrib.auth.backends.ModelBackend")
    return redirect("home")


def person(platform, claims):
    """Returns the user of a launch and the class, if the roster knows it. A new subject gets a pseudonym."""
    teacher = ROLE + "Instructor" in claims.get(CLAIM + "roles", [])
    group = Class.objects.exclude(source_id="").filter(source_id=str(claims.get(CLAIM + "context", {}).get("id", ""))).first()
    known = Identity.objects.filter(platform=platform, subject=claims["sub"]).select_related("user").first()
    source = str(claims.get(CLAIM + "lis", {}).get("person_sourcedid", ""))
    student = Student.objects.exclude(source_id="").filter(source_id=source).first() if source else None
    if known:
        user = known.user
    elif student and student.user:
        user = student.user
    else:
        user = User(username=("t-" if teacher else "s-") + secrets.token_hex(5), is_staff=teacher)
        user.set_unusable_password()
        user.save()
        if not teacher:
            Student.objects.create(pseudonym=user.username, user=user)
    if not user.is_active or user.is_superuser:  # an administrator signs in here, never through a platform
        raise PermissionDenied
    Identity.objects.get_or_create(platform=platform, subject=claims["sub"], defaults={"user": user})
    if group and hasattr(user, "student"):
        user.student.classes.add(group)
    elif group and teacher and user.is_staff:
        group.teachers.add(user)
    return user, group


def remember_line_item(platform, claims, group):
    """A link whose custom parameter `assignment` names an assignment of the class gives it a column of grades."""
    line_item, number = claims.get(AGS, {}).get("lineitem"), str(claims.get(CLAIM + "custom", {}).get("assignment", ""))
    if line_item and group and number.isdecimal() and same_origin(line_item, platform.token_url):
        Assignment.objects.filter(pk=int(number), group=group).filter(Q(platform=None) | Q(platform=platform)).update(
            line_item=str(line_item)[:500], platform=platform)


def same_origin(one, other):
    one, other = urllib.parse.urlsplit(one), urllib.parse.urlsplit(other)
    return (one.scheme, one.netloc) == (other.scheme, other.netloc)


def queue_grade(session):
    """A checked session of an assignment with a line item waits to be sent, if it is the student's best."""
    assignment = session.assignment
    if not assignment or not assignment.line_item or session.points is None:
        return
    best = Session.objects.filter(assignment=assignment, student=session.student, state=Session.ACCEPTED).exclude(pk=session.pk).filter(points__gte=session.points)
    identity = Identity.objects.filter(platform=assignment.platform, user__student=session.student).first()
    if identity and not best.exists():
        Grade.objects.update_or_create(session=session, defaults={"subject": identity.subject})


def post(url, data, **headers):
    with urllib.request.urlopen(urllib.request.Request(url, data, headers), timeout=20) as answer:
        return json.loads(answer.read(1 << 20) or b"{}")


def token_of(platform):
    now = int(time.time())
    assertion = jwt.encode({"iss": platform.client_id, "sub": platform.client_id, "aud": platform.token_url, "iat": now, "exp": now + 300,
                            "jti": secrets.token_hex(16)}, own_key(), "RS256", headers={"kid": "school"})
    form = {"grant_type": "client_credentials", "client_assertion_type": "urn:ietf:params:oauth:client-assertion-type:jwt-bearer",
            "client_assertion": assertion, "scope": SCORE_SCOPE}
    return post(platform.token_url, urllib.parse.urlencode(form).encode())["access_token"]


def send_grades():
    """Sends waiting grades; a failed one is tried again at the next call. Returns how many were sent."""
    sent = 0
    for grade in Grade.objects.filter(sent=None, tries__lt=MAX_TRIES).select_related("session__assignment__platform"):
        session, assignment = grade.session, grade.session.assignment
        if not assignment or not assignment.platform:
            grade.delete()
            continue
        score = {"userId": grade.subject, "scoreGiven": round(session.points, 2), "scoreMaximum": 100, "activityProgress": "Completed",
                 "gradingProgress": "FullyGraded", "timestamp": session.received.isoformat()}
        url, query = assignment.line_item.partition("?")[::2]
        try:
            post(url.rstrip("/") + "/scores" + ("?" + query if query else ""), json.dumps(score).encode(),
                 **{"Content-Type": "application/vnd.ims.lis.v1.score+json", "Authorization": "Bearer " + token_of(assignment.platform)})
            grade.sent, grade.error, sent = timezone.now(), "", sent + 1
        except (urllib.error.URLError, OSError, ValueError, KeyError) as problem:
            grade.tries, grade.error = grade.tries + 1, str(problem)[:300]
        grade.save()
    return sent
