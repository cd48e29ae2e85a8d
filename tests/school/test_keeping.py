"""Backup of a running service, and new scores for stored sessions."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
from unittest import mock

from django.conf import settings
from django.test import Client, TransactionTestCase

from room import PASSWORD, Room, record, sha256
from service import ServiceTest
from typodont_school import program, rescoring
from typodont_school.models import Session


class Backup(ServiceTest):
    def back_up(self, folder):
        return subprocess.run([sys.executable, "-m", "typodont_school", "backup", folder], env=self.environment, capture_output=True, text=True)

    def test_a_copy_of_a_running_service_is_a_service_with_all_sessions(self):
        self.environment.pop("TYPODONT_SCHOOL_DATABASE", None)
        server, bench = self.start_with_bench(4)
        kept = self.folder / "kept"
        sent = subprocess.Popen(bench, env=self.environment, stdout=subprocess.DEVNULL)
        while sent.poll() is None:  # while sessions arrive and are checked
            done = self.back_up(kept)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.wait_for_checks(server, 4)
        files = {file: file.stat().st_mtime_ns for file in (kept / "sessions").rglob("*.h5")}
        self.assertEqual(self.back_up(kept).stdout, f"{4 - len(files)} new recordings\n")  # only what is new
        self.assertEqual({file: file.stat().st_mtime_ns for file in files}, files)
        self.assertEqual(len(list((kept / "sessions").rglob("*.h5"))), 4)
        server.kill()
        server.wait()
        shutil.rmtree(self.folder / "data")
        self.environment["TYPODONT_SCHOOL_DATA"] = str(kept)
        self.start()
        for number in range(4):
            file = record(f"hand{number}", "nobody", number)
            self.assertIn(f"/session/{sha256(file)}", self.get("/administration"))  # still signed in
            with self.browser.open(f"{self.address}/session/{sha256(file)}/recording.h5") as answer:
                self.assertEqual(answer.read(), file.read_bytes())

    def test_only_an_empty_folder_or_an_own_backup_is_written(self):
        self.environment.pop("TYPODONT_SCHOOL_DATABASE", None)
        server, _ = self.start()
        server.terminate()
        server.wait()
        other = self.folder / "other"
        other.mkdir()
        (other / "letter.txt").write_text("mine")
        for folder in (other, self.folder / "data" / "inside"):
            self.assertIn("no backup: ", self.back_up(folder).stderr)
        self.environment["TYPODONT_SCHOOL_DATA"] = str(self.folder / "nowhere")
        self.assertIn("no backup: ", self.back_up(self.folder / "kept").stderr)
        self.assertFalse((self.folder / "nowhere/school.sqlite").exists())
        self.assertEqual([file.name for file in other.iterdir()], ["letter.txt"])


class Rescored(TransactionTestCase):
    def test_sessions_get_new_points_beside_the_old_ones_on_dask(self):
        from distributed import LocalCluster
        door = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (door / "lib").mkdir()
        (door / "lib/libtypodont.so.0").symlink_to(pathlib.Path(settings.PROGRAM).with_name("libtypodont.so.0"))
        (door / "include").symlink_to(settings.TREE / "engine/bindings/c")
        package = str(settings.TREE / "engine/bindings/python")
        self.enterContext(mock.patch.dict(os.environ, TYPODONT_PREFIX=str(door), PYTHONPATH=package))
        self.enterContext(mock.patch.object(sys, "path", [package, *sys.path]))
        room = Room()
        sessions = [room.judged(record(f"again{number}", "anna", number)) for number in range(3)]
        with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
            self.assertEqual(rescoring.rescore_all(cluster.scheduler_address), 0)  # this program scored them
            Session.objects.update(program="older")
            Session.objects.filter(pk=sessions[1].pk).update(points=77)
            self.assertEqual(rescoring.rescore_all(cluster.scheduler_address), 3)
        self.assertEqual(rescoring.rescore_all(), 0)
        for session in sessions:
            again = session.rescores.get()
            self.assertEqual((again.program, again.points, again.passed, again.error), (program.version(), session.points, session.passed, ""))
        client = Client()
        client.login(username="teacherA", password=PASSWORD)
        pages = [client.get(f"/session/{session.pk}").content.decode() for session in sessions]
        self.assertEqual([program.version() in page for page in pages], [False, True, False])
        self.assertIn("77.00", pages[1])
