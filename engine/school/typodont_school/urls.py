from django.urls import path, register_converter

from . import interface, lti, views


class Sha:
    regex = "[0-9a-f]{64}"
    to_python = to_url = str


register_converter(Sha, "sha")
handler403 = handler404 = views.refused
urlpatterns = [
    path("", views.home, name="home"),
    path("sign-in", views.sign_in, name="sign_in"),
    path("sign-out", views.sign_out, name="sign_out"),
    path("password", views.password, name="password"),
    path("language", views.language, name="language"),
    path("classes", views.classes, name="classes"),
    path("class/<int:key>", views.group, name="class"),
    path("class/<int:key>/exercise/<int:exercise_key>", views.exercise, name="exercise"),
    path("class/<int:key>/assign", views.assign, name="assign"),
    path("class/<int:key>/case", views.add_case, name="add_case"),
    path("exercise/<int:key>/files.zip", views.case_files, name="case_files"),
    path("class/<int:key>/students", views.add_students, name="add_students"),
    path("class/<int:key>/scores.csv", views.scores_csv, name="scores_csv"),
    path("class/<int:key>/scores.json", views.scores_json, name="scores_json"),
    path("class/<int:key>/statements.json", views.statements, name="statements"),
    path("student/<int:key>", views.student, name="student"),
    path("student/<int:key>/export.zip", views.export, name="export"),
    path("student/<int:key>/delete", views.delete, name="delete"),
    path("session/<sha:key>", views.session, name="session"),
    path("session/<sha:key>/report.html", views.report, name="report"),
    path("session/<sha:key>/film", views.film, name="film"),
    path("session/<sha:key>/film.mp4", views.film_file, name="film_file"),
    path("session/<sha:key>/recording.h5", views.recording, name="recording"),
    path("session/<sha:key>/remarks.json", views.remarks, name="remarks"),
    path("session/<sha:key>/remark", views.remark, name="remark"),
    path("administration", views.administration, name="administration"),
    path("administration/bench", views.add_bench, name="add_bench"),
    path("administration/class", views.add_class, name="add_class"),
    path("administration/roster", views.roster, name="roster"),
    path("administration/platform", views.add_platform, name="add_platform"),
    path("api/hand-in/<sha:sha>", interface.hand_in, name="hand_in"),
    path("api/exam/<int:key>", interface.exam, name="exam"),
    path("api/exam/progress", interface.exam_progress, name="exam_progress"),
    path("api/sign-in", interface.bench_sign_in, name="bench_sign_in"),
    path("api/me", interface.me, name="me"),
    path("api/assignment/<int:key>/files.zip", interface.assignment_files, name="assignment_files"),
    path("xapi/profile.json", views.profile, name="profile"),
    path("lti/sign-in", lti.sign_in, name="lti_sign_in"),
    path("lti/launch", lti.launch, name="lti_launch"),
    path("lti/keys.json", lti.keys, name="lti_keys"),
]
