"""Films of sessions: made for those who ask, one at a time, served in parts."""
import json
import subprocess
from unittest import mock

from django.test import Client, TestCase
from django.urls import reverse

from room import PASSWORD, Room, record
from typodont_school import films, intake, program
from typodont_school.models import Film, Session

MADE = {}  # the film of this recording; each test gets a copy


class Films(TestCase):
    def setUp(self):
        self.room = Room()
        self.session = self.room.judged(record("anna", "anna"))
        self.client = self.signed_in("anna")
        self.address, self.file = (reverse(name, args=[self.session.pk]) for name in ("film", "film_file"))

    def signed_in(self, who):
        client = Client()
        client.login(username=who, password=PASSWORD)
        return client

    def made(self):
        """The film that the program makes of the recording."""
        if not MADE:
            self.assertEqual(self.client.post(self.address).status_code, 302)
            with mock.patch.multiple(program, FILM_NICE=0, MAX_FPS=5):  # soon, also on a busy machine
                self.assertEqual(films.make_waiting(), 1)
            film = Film.objects.get()
            self.assertEqual((film.state, film.reason), ("ready", ""))
            MADE["bytes"] = films.file_of(self.session.pk).read_bytes()
        Film.objects.update_or_create(session=self.session, defaults={"state": Film.READY, "size": len(MADE["bytes"])})
        films.file_of(self.session.pk).write_bytes(MADE["bytes"])
        return MADE["bytes"]

    def test_nothing_is_made_unasked(self):
        self.assertEqual(self.client.get(self.address).json(), {"state": "none"})
        self.assertEqual((films.make_waiting(), self.client.get(self.file).status_code), (0, 409))

    def test_the_film_shows_the_session_for_its_whole_duration(self):
        self.made()
        self.assertEqual(self.client.get(self.address).json(), {"state": "ready"})
        shown = json.loads(subprocess.run(["ffprobe", "-v", "error", "-of", "json", "-show_streams", "-count_frames", films.file_of(self.session.pk)],
                                          check=True, capture_output=True).stdout)["streams"]
        picture = next(s for s in shown if s["codec_type"] == "video")
        self.assertEqual((picture["codec_name"], picture["width"], picture["height"]), ("h264", 1280, 720))
        self.assertAlmostEqual(float(picture["duration"]), self.session.seconds, delta=0.3)
        self.assertEqual(list(intake.folder("work").iterdir()), [])

    def test_parts_of_the_film_are_its_bytes(self):
        data = self.made()
        size = len(data)
        for asked, first, last in (("bytes=0-0", 0, 0), ("bytes=100-", 100, size - 1), ("bytes=-70000", size - 70000, size - 1), (f"bytes=5-{size * 9}", 5, size - 1),
                                   (f"bytes=-{size * 9}", 0, size - 1)):
            answer = self.client.get(self.file, HTTP_RANGE=asked)
            self.assertEqual((answer.status_code, answer["Content-Range"], answer["Content-Length"]), (206, f"bytes {first}-{last}/{size}", str(last - first + 1)))
            self.assertEqual(b"".join(answer.streaming_content), data[first:last + 1])
        for beyond in (f"bytes={size}-", "bytes=-0", "bytes=9-2"):
            answer = self.client.get(self.file, HTTP_RANGE=beyond)
            self.assertEqual((answer.status_code, answer["Content-Range"]), (416, f"bytes */{size}"))
        for whole in ("", "bytes=-", "lines=0-1", "bytes=0-1,5-6", "bytes=١-"):
            answer = self.client.get(self.file, HTTP_RANGE=whole)
            self.assertEqual((answer.status_code, b"".join(answer.streaming_content)), (200, data), whole)

    def test_the_queue_survives_a_killed_service(self):
        self.client.post(self.address)
        with mock.patch.object(program, "film", side_effect=SystemExit):
            self.assertRaises(SystemExit, films.make_waiting)
        self.assertEqual(Film.objects.get().state, "making")
        with mock.patch.object(program, "film", side_effect=lambda recording, out, *_: out.write_bytes(b"film")):
            self.assertEqual(films.make_waiting(), 1)
        self.assertEqual((Film.objects.get().state, films.file_of(self.session.pk).read_bytes()), ("ready", b"film"))

    def test_a_film_that_takes_too_long_or_grows_too_large_fails_with_its_reason(self):
        for limits, more in (({program.resource.RLIMIT_CPU: 1}, {}), ({program.resource.RLIMIT_FSIZE: 1000}, {}), ({}, {"FILM_TIME": 0.2})):
            with mock.patch.multiple(program, FILM_LIMITS={**program.FILM_LIMITS, **limits}, **more):
                self.client.post(self.address)
                self.assertEqual(films.make_waiting(), 1)
            film = Film.objects.get()
            self.assertEqual(film.state, "failed")
            self.assertTrue(film.reason)
            self.assertContains(self.client.get(reverse("session", args=[self.session.pk])), "The film could not be made")
            self.assertFalse(films.file_of(self.session.pk).exists())

    def test_a_long_session_has_a_bounded_number_of_pictures(self):
        for seconds in (1, 60, 600, 3600, 36000):
            with mock.patch.object(program, "run", return_value=(0, b"", "")) as run:
                self.assertRaises(program.Refused, program.film, "in.h5", intake.folder("work") / "absent", seconds, "window", "en")
            words = run.call_args[0]
            fps, speed = (float(words[words.index(option) + 1]) for option in ("--fps", "--speed"))
            self.assertLessEqual(fps * seconds / speed, 1.001 * program.MAX_FRAMES)

    def test_a_deleted_session_takes_its_film_along_also_while_it_is_made(self):
        self.made()
        root, here = self.signed_in("root"), films.file_of(self.session.pk).parent
        def delete(*_):
            root.post(reverse("delete", args=[self.room.anna.pk]), {"pseudonym": "anna"})
            self.assertFalse(here.exists())
        def delete_meanwhile(recording, out, *_):
            out.write_bytes(b"film")
            delete()
        Film.objects.update(state=Film.WAITING)
        with mock.patch.object(program, "film", side_effect=delete_meanwhile):
            films.make_waiting()
        self.assertFalse(Session.objects.exists() or Film.objects.exists() or here.exists())

    def test_a_person_has_five_films_in_the_queue_at_most(self):
        with mock.patch.object(films, "MAX_WAITING", 0):
            self.assertEqual(self.client.post(self.address).status_code, 429)
        self.assertEqual([self.client.post(self.address).status_code for _ in range(2)], [302, 302])
        self.assertEqual(Film.objects.count(), 1)

    def test_the_oldest_films_make_room_for_new_ones(self):
        self.made()
        with mock.patch.object(intake.settings, "MAX_FILMS_BYTES", len(MADE["bytes"])):
            films.make_room()
            self.assertTrue(films.file_of(self.session.pk).exists())
        with mock.patch.object(intake.settings, "MAX_FILMS_BYTES", len(MADE["bytes"]) - 1):
            films.make_room()
        self.assertFalse(films.file_of(self.session.pk).exists() or Film.objects.exists())
