"""Statements of the Experience API (xAPI 1.0.3), and the profile that names their parts."""
import uuid

from django.conf import settings

from .words import LANGUAGES

COMPLETED = "http://adlnet.gov/expapi/verbs/completed"


def iri(part):
    return f"{settings.ADDRESS}/xapi/profile.json#{part}"


def statement(session, items):
    """Returns the statement of one checked session. The same session always gives the same id."""
    return {
        "id": str(uuid.uuid5(uuid.NAMESPACE_URL, "sha256:" + session.sha256)),
        "version": "1.0.3",
        "actor": {"objectType": "Agent", "account": {"homePage": settings.ADDRESS, "name": session.student.pseudonym}},
        "verb": {"id": COMPLETED, "display": {"en": "completed"}},
        "object": {"objectType": "Activity", "id": f"{settings.ADDRESS}/exercise/{session.exercise.name}", "definition": {
            "type": iri("exercise"), "name": {code: session.exercise.title(code) for code in LANGUAGES}}},
        "result": {"score": {"scaled": round(session.points / 100, 6), "raw": session.points, "min": 0, "max": 100},
                   "success": bool(session.passed), "duration": f"PT{session.seconds:.3f}S",
                   "extensions": {iri("items"): items, iri("recording"): session.sha256}},
        "context": {"extensions": {iri("attempt"): session.attempt}, "contextActivities": {"category": [{"id": iri("profile")}]}},
        "timestamp": session.received.isoformat(), "stored": session.received.isoformat()}


def profile():
    concept = lambda name, kind, text: {"id": iri(name), "type": kind, "inScheme": iri("profile"), "prefLabel": {"en": name}, "definition": {"en": text}}
    return {
        "@context": "https://w3id.org/xapi/profiles/context", "id": iri("profile"), "type": "Profile",
        "conformsTo": "https://w3id.org/xapi/profiles#1.0", "prefLabel": {"en": "Haptic dentistry"},
        "definition": {"en": "Sessions on a haptic workbench for dental training, scored from the recorded hand."},
        "concepts": [
            concept("exercise", "ActivityType", "A task on a simulated tooth or bone, with an ideal result."),
            concept("items", "ResultExtension", "Measured values of the session, by the names of the score's rules; the unit ends the name."),
            concept("recording", "ResultExtension", "SHA-256 of the recording, from which anybody can compute the score again."),
            concept("attempt", "ContextExtension", "Number of this session among the student's sessions of the exercise.")],
        "templates": [{"id": iri("session"), "type": "StatementTemplate", "inScheme": iri("profile"), "verb": COMPLETED,
                       "objectActivityType": iri("exercise"), "rules": [{"location": "$.result.score.scaled", "presence": "included"}]}]}
