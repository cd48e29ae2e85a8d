"""The package `typodont` as its users have it: installed from its wheel. python_test.py PROGRAM runs all; each class says
what holds. It needs pandas, distributed, h5py and matplotlib, too."""

import base64
import contextlib
import csv
import inspect
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import matplotlib
import numpy as np
import typodont
from matplotlib import pyplot

matplotlib.use("Agg")
PROGRAM = os.path.abspath(sys.argv[1])
NOTEBOOKS = Path(__file__).resolve().parents[3] / "docs" / "notebooks"
BALL = {
    "tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 2}}}]},
    "tool": "round_012",
    "spindle_krpm": 300,
}
HAND = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,3,1,0,0,0,1\n0.3,0,0,2.3,1,0,0,0,1\n0.6,0.4,0,2.3,1,0,0,0,1\n"


def path(depth_mm=0.3):
    return typodont.Path([0, 0.2, 0.4], [[0, 0, 2.8], [0, 0, 2.6 - depth_mm], [0, 0, 2.6 - depth_mm]])


def slow(ticks, core):
    """A measure that takes its time, for workers to be killed in."""
    time.sleep(0.3)
    return {"process": os.getpid()}


def kill_once(ticks, core):
    """Kills its own process the first time it is called, wherever that is."""
    try:
        os.close(os.open(os.environ["KILLED_ONCE"], os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return {"survived": True}
    os.kill(os.getpid(), signal.SIGKILL)


def kill_always(ticks, core):
    if len(ticks) == 401 and core.volumes_mm3["dentin"] > 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return {}


class InFolder(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)


class Cases(InFolder):
    def test_a_case_is_the_programs_and_opens_as_a_scene(self):
        case = typodont.Case("access-front", 4, 0.25, out=self.folder / "case.json", tooth="U1", program=PROGRAM)
        self.assertEqual(case.tooth, "U1")
        self.assertTrue(18 <= case.parameters["age"] <= 48)
        self.assertTrue(case.careless_points <= 60 and 95 <= case.expert_points)
        with case.scene() as scene:
            self.assertEqual(scene.json["case"], {"family": "access-front", "seed": 4, "difficulty": 0.25})
        with self.assertRaisesRegex(typodont.BadInput, "class-1"):
            typodont.Case("class-9", out=self.folder / "bad.json", program=PROGRAM)


class Ticks(InFolder):
    def test_every_column_is_what_the_program_writes_to_the_bit(self):
        (self.folder / "ball.json").write_text(json.dumps(BALL))
        (self.folder / "hand.csv").write_text(HAND)
        subprocess.run([PROGRAM, "servo", "ball.json", "--hand", "hand.csv", "--out", "t.csv", "--no-timing"], check=True,
                       cwd=self.folder, stdout=subprocess.DEVNULL)
        with typodont.Scene(self.folder / "ball.json") as scene:
            ticks = scene.servo(self.folder / "hand.csv")
        with open(self.folder / "t.csv") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(ticks))
        for name in rows[0]:
            if name in ("tick_us", "tissue"):
                continue
            np.testing.assert_array_equal(np.array([float(row[name]) for row in rows]), ticks[name], name)
        self.assertEqual([row["tissue"] for row in rows], [typodont.TISSUES[i] for i in ticks["tissue"]])
        self.assertGreater(ticks["removed_mm3"][-1], 0)

    def test_columns_are_views_without_copies(self):
        with typodont.Scene(BALL) as scene:
            ticks = scene.servo(path())
        self.assertTrue(np.shares_memory(ticks["force_z_N"], ticks.array))
        self.assertTrue(np.shares_memory(ticks.force, ticks.array))
        with self.assertRaises(KeyError):
            ticks["force_z_kN"]

    def test_a_frame_has_the_columns_of_the_tables(self):
        with typodont.Scene(BALL) as scene:
            frame = scene.servo(path()).frame()
        self.assertIn("removed_enamel_mm3", frame.columns)
        self.assertEqual(len(frame), 401)


class Errors(unittest.TestCase):
    def test_bad_input_raises_and_says_why(self):
        with self.assertRaisesRegex(typodont.BadInput, "molar-caries"):
            typodont.Scene("no such scene")
        with self.assertRaisesRegex(typodont.BadInput, "tissue"):
            typodont.Scene({"tool": "round_012"})
        with typodont.Scene(BALL) as scene, self.assertRaises(typodont.BadInput):
            scene.servo(typodont.Path([0, 0], np.zeros((2, 3))))

    def test_a_pose_that_is_none_raises_and_the_core_goes_on(self):
        with typodont.Scene(BALL) as scene, scene.core() as core:
            core.tick(0, (0, 0, 2.7))
            with self.assertRaises(typodont.BadInput):
                core.tick(0.001, (float("nan"), 0, 0))
            self.assertEqual(core.tick(0.002, (0, 0, 2.7))["faults"], 0)

    def test_a_clock_that_runs_backwards_or_too_far_raises_and_the_recording_is_readable(self):
        with tempfile.TemporaryDirectory() as folder, typodont.Scene(BALL) as scene:
            file = os.path.join(folder, "s.h5")
            with scene.core() as core:
                core.record(file)
                core.tick(1, (0, 0, 2.7))
                for t in (0.5, -1, 1e6):
                    with self.assertRaises(typodont.BadInput):
                        core.tick(t, (0, 0, 2.7))
                self.assertEqual(core.tick(1.001, (0, 0, 2.7))["faults"], 0)
                core.finish()
            with typodont.Session(file) as session:
                self.assertEqual(list(session.ticks.array["t_ns"]), [10**9] * 4 + [1001 * 10**6])

    def test_an_error_whose_text_is_not_utf8_raises_the_right_exception(self):
        with self.assertRaises(typodont.BadInput):
            typodont.Scene(os.fsdecode(b"/nowhere/\xff.json"))

    def test_what_was_closed_raises(self):
        with typodont.Scene(BALL) as scene:
            core = scene.core()
        core.close()
        with self.assertRaises(typodont.Closed):
            core.mesh()
        with self.assertRaises(typodont.Closed):
            scene.tools

    def test_a_second_thread_at_once_raises(self):
        with typodont.Scene(BALL) as scene, scene.core() as core, typodont.Hand(scene, path()) as hand:
            refused = threading.Event()

            def look():
                while not refused.is_set():
                    try:
                        core.volumes_mm3
                    except typodont.Closed:
                        refused.set()

            other = threading.Thread(target=look)
            other.start()
            while not refused.is_set():
                try:
                    core.mesh()
                except typodont.Closed:
                    refused.set()
            other.join()


class Tissue(unittest.TestCase):
    def test_the_surface_of_a_ball_lies_on_it_and_is_updated_where_it_is_cut(self):
        with typodont.Scene(BALL) as scene, typodont.Hand(scene, path()) as hand, scene.core(hand=hand) as core:
            whole = core.mesh()
            for part in whole:
                away = np.linalg.norm(part.vertices["position"], axis=1)
                np.testing.assert_allclose(away, 2e-3, atol=2e-5)
            before = [part.vertices.copy() for part in whole]
            core.run(hand)
            changed = core.mesh()
            self.assertLess(len(changed), len(whole))
            self.assertGreater(len(changed), 0)
            self.assertEqual(core.mesh(), [])
        for part, vertices in zip(whole, before):  # also after the core was closed
            np.testing.assert_array_equal(part.vertices, vertices)

    def test_points_of_another_shape_raise(self):
        with typodont.Scene(BALL) as scene, scene.core() as core:
            for shape in ((20000, 2), (40000, 1), (5,), (2, 2, 3)):
                with self.assertRaises(typodont.BadInput):
                    core.distance(np.zeros(shape))

    def test_distances_and_volumes_are_those_of_the_ball(self):
        with typodont.Scene(BALL) as scene, scene.core() as core:
            distance, tissue = core.distance([[0, 0, 2.5], [0, 0, 1.5], [1, 1, 1]])
            np.testing.assert_allclose(distance, [0.5, -0.5, np.sqrt(3) - 2], atol=0.003)
            self.assertEqual(tissue.tolist(), [0, 1, 1])
            volume = 4 / 3 * np.pi * 8
            self.assertAlmostEqual(core.volumes_mm3["enamel"], volume, delta=0.002 * volume)
            field = core.field()
            self.assertEqual(field.distance.shape, field.tissue.shape)
            self.assertLess(field.distance.min(), 0)

    def test_an_undone_stroke_leaves_the_tissue_as_it_was(self):
        with typodont.Scene(BALL) as scene, typodont.Hand(scene, path()) as hand, scene.core(hand=hand) as core:
            before = core.hash
            core.run(hand)
            self.assertNotEqual(core.hash, before)
            while core.undo():
                pass
            self.assertEqual(core.hash, before)
            self.assertTrue(core.redo())


class Sessions(InFolder):
    def test_a_recorded_run_is_read_back_and_replayed(self):
        file = self.folder / "s.h5"
        with typodont.Scene(BALL) as scene:
            ticks = scene.servo(path(), record=file, trainee="Ada")
        with typodont.Session(file) as session:
            np.testing.assert_array_equal(session.ticks.force, ticks.force)
            self.assertEqual(session.text("trainee"), "Ada")
            self.assertEqual(session.scene["tool"], "round_012")
            self.assertEqual(session.cuts["index"][-1], ticks.array["cuts"][-1])
            self.assertFalse(session.truncated)
            self.assertTrue(session.replay(program=PROGRAM)["identical"])


class Doors(unittest.TestCase):
    def test_sound_follows_the_spindle(self):
        with typodont.Scene(BALL) as scene, typodont.Synth("micromotor", seed=3) as synth:
            sound = synth.voice(scene.servo(path()))
        self.assertGreater(len(sound), 10_000)
        self.assertGreater(sound.std(), 1e-4)

    def test_registration_finds_the_motion_that_moved_the_points(self):
        points = np.random.default_rng(1).normal(size=(16, 3)) * 30
        turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
        seen = points @ turn.T + [1, 2, 3]
        seen[4] += 20
        found = typodont.calibration.register(points, seen)
        np.testing.assert_allclose(found.matrix[:3, :3], turn, atol=1e-9)
        np.testing.assert_allclose(found.matrix[:3, 3], [1, 2, 3], atol=1e-6)
        self.assertEqual(np.flatnonzero(~found.inliers).tolist(), [4])
        self.assertTrue(found.trusted)
        self.assertFalse(typodont.calibration.register(points[:2], seen[:2]).trusted)

    def test_everything_public_has_a_docstring_and_the_package_its_types(self):
        self.assertTrue((Path(typodont.__file__).parent / "py.typed").exists())
        for name in typodont.__all__:
            thing = getattr(typodont, name)
            if inspect.isclass(thing) or inspect.isfunction(thing) or inspect.ismodule(thing):
                self.assertTrue(inspect.getdoc(thing), name)
            if inspect.isfunction(thing):
                self.assertIn("return", thing.__annotations__, name)


class Pictures(InFolder):
    def test_a_picture_shows_the_tissue_and_the_tool_as_they_are_now_and_a_sessions_moment_is_the_same_picture(self):
        file, size = self.folder / "s.h5", (160, 120)
        # Core.render() saves the tissue with distances in mm. With voxels of 1/8 mm, this changes no bit of them.
        ball = {**BALL, "tissue": {**BALL["tissue"], "voxel_mm": 0.125}}
        with typodont.Scene(ball) as scene, typodont.Hand(scene, path()) as hand, scene.core(hand=hand) as core:
            before = core.render(size=size, program=PROGRAM)
            core.record(file)
            core.run(hand)
            core.finish()
            after = core.render(size=size, program=PROGRAM)
            above = core.render(size=size, towards=(0, 0, -1), zoom=2, eye="both", program=PROGRAM)
        self.assertEqual((before.shape, before.dtype), ((120, 160, 3), np.uint8))
        lit, wall = before[60, 80].mean(), before[5, 5].mean()
        self.assertGreater(lit, wall + 80)
        self.assertEqual(int(np.abs(after[100:].astype(int) - before[100:]).max()), 0, "below the ball nothing changed")
        self.assertGreater(np.abs(after[:60].astype(int) - before[:60]).max(), 50, "the tool came from above")
        self.assertEqual(above.shape, (2, 120, 160, 3))
        self.assertTrue((above[0] != above[1]).any(), "two eyes see two pictures")
        with typodont.Session(file) as session:
            np.testing.assert_array_equal(session.render(1.0, size=size, program=PROGRAM), after)

    def test_what_cannot_be_drawn_raises(self):
        with typodont.Scene(BALL) as scene, scene.core() as core:
            for wrong in ({"rig": "no such rig"}, {"eye": "middle"}, {"towards": (0, 0, 0)}, {"size": (0, 10)}):
                with self.assertRaises(typodont.BadInput):
                    core.render(program=PROGRAM, **wrong)
            with self.assertRaisesRegex(typodont.Error, "no program"):
                core.render(program="/no/such/program")


def rows_of(table):
    return table if isinstance(table, list) else json.loads(table.to_json(orient="records"))


class Sweeps(InFolder):
    def test_a_killed_process_costs_no_run(self):
        os.environ["KILLED_ONCE"] = str(self.folder / "killed")
        table = rows_of(typodont.sweep(BALL, [path(d) for d in (0.1, 0.2, 0.3)], {"friction": [True, False]}, workers=2,
                                       measure=kill_once))
        self.assertTrue((self.folder / "killed").exists())
        self.assertEqual(len(table), 6)
        self.assertTrue(all(row["survived"] for row in table))
        self.assertEqual([row["friction"] for row in table], [True, False] * 3)
        self.assertGreater(table[4]["removed_mm3"], table[0]["removed_mm3"])

    def test_a_run_that_always_kills_its_process_is_a_row_with_an_error_and_costs_no_other(self):
        dentin = {**BALL, "name": "dentin", "tissue": {"voxel_mm": 0.1, "solids": [
            {"tissue": "dentin", "solid": {"sphere": {"radius_mm": 2}}}]}}
        table = rows_of(typodont.sweep({"enamel": BALL, "dentin": dentin}, [path(0.1), path(0.2)], workers=2,
                                       measure=kill_always))
        self.assertEqual([bool(row.get("error")) for row in table], [False, False, True, True])

    def test_what_was_done_is_not_done_again(self):
        first = rows_of(typodont.sweep(BALL, path(), {"model": ["offset", "voxel_penalty"]}, folder=self.folder / "r",
                                       workers=2))
        kept = {file: file.stat().st_mtime_ns for file in (self.folder / "r").iterdir()}
        self.assertEqual(len(kept), 2)
        told = []
        again = rows_of(typodont.sweep(BALL, path(), {"model": ["offset", "voxel_penalty", "vertex"]},
                                       folder=self.folder / "r", workers=2, progress=lambda d, n: told.append((d, n))))
        self.assertEqual(again[:2], first)
        self.assertEqual(told, [(3, 3)])
        self.assertEqual({file: file.stat().st_mtime_ns for file in kept}, kept)

    def test_a_run_is_done_again_where_a_file_that_its_scene_names_has_changed(self):
        volume = self.folder / "ball.vdb"
        scene = {**BALL, "tissue": {"volume": str(volume)}}
        hashes = []
        for radius in (2, 2.1, None):
            if radius:
                with typodont.Scene({**BALL, "tissue": {"voxel_mm": 0.1, "solids": [
                        {"tissue": "enamel", "solid": {"sphere": {"radius_mm": radius}}}]}}) as made, made.core() as core:
                    core.save(volume)
            told = []
            table = rows_of(typodont.sweep(scene, path(), folder=self.folder / "r", workers=1,
                                           progress=lambda done, count: told.append(done)))
            hashes.append((table[0]["field_hash"], len(told)))
        self.assertNotEqual(hashes[0][0], hashes[1][0])
        self.assertEqual(hashes[2], (hashes[1][0], 0))

    def test_on_a_cluster_a_dead_workers_runs_are_repeated(self):
        from distributed import Client

        def start(command, *words):
            process = subprocess.Popen([sys.executable, "-W", "ignore", "-m", f"distributed.cli.dask_{command}",
                                        "--scheduler-file", self.folder / "scheduler.json", "--no-dashboard", *words],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=self.folder)
            self.addCleanup(process.wait)
            self.addCleanup(process.kill)
            return process

        start("scheduler", "--port", "0", "--host", "127.0.0.1")
        workers = [start("worker", "--no-nanny", "--nthreads", "1", "--host", "127.0.0.1") for _ in range(2)]
        while not (self.folder / "scheduler.json").exists():
            time.sleep(0.01)
        told = []

        def kill_one(done, count):
            told.append(done)
            if done == 1:
                workers[0].kill()

        hands = [path(0.05 * i) for i in range(6)]
        with Client(scheduler_file=str(self.folder / "scheduler.json"), timeout=120) as client:
            client.wait_for_workers(2)
            table = rows_of(typodont.sweep(BALL, hands, scheduler=client, measure=slow, progress=kill_one))
        self.assertEqual(told, [1, 2, 3, 4, 5, 6])
        self.assertEqual(workers[0].wait(), -signal.SIGKILL)
        self.assertIn(workers[1].pid, {row["process"] for row in table})
        here = rows_of(typodont.sweep(BALL, hands, workers=2))
        self.assertEqual([row["field_hash"] for row in table], [row["field_hash"] for row in here])


def outputs_of(printed):
    """What a notebook stores of a cell: its text, and the figures that it left open."""
    outputs = [{"output_type": "stream", "name": "stdout", "text": printed.splitlines(True)}] if printed else []
    for number in pyplot.get_fignums():
        picture = io.BytesIO()
        pyplot.figure(number).savefig(picture, format="png", dpi=80, bbox_inches="tight")
        data = {"image/png": base64.b64encode(picture.getvalue()).decode()}
        outputs.append({"output_type": "display_data", "data": data, "metadata": {}})
    pyplot.close("all")
    return outputs


class Notebooks(InFolder):
    """With TYPODONT_WRITE_NOTEBOOKS, the outputs are stored."""

    def test_every_notebook_runs_from_its_first_cell_to_its_last_and_carries_what_its_cells_print_and_plot(self):
        notebooks = sorted(NOTEBOOKS.glob("*.ipynb"))
        self.assertEqual(len(notebooks), 5)
        was = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, was)
        for notebook in notebooks:
            with self.subTest(notebook.name):
                space = {"__name__": "__main__"}
                document = json.loads(notebook.read_text())
                for i, cell in enumerate(document["cells"]):
                    if cell["cell_type"] != "code":
                        continue
                    with contextlib.redirect_stdout(io.StringIO()) as printed:
                        exec(compile("".join(cell["source"]), f"{notebook.name}, cell {i}", "exec"), space)
                    outputs = outputs_of(printed.getvalue())
                    if "TYPODONT_WRITE_NOTEBOOKS" in os.environ:
                        cell["outputs"] = outputs
                    self.assertEqual([o["output_type"] for o in cell["outputs"]], [o["output_type"] for o in outputs])
                if "TYPODONT_WRITE_NOTEBOOKS" in os.environ:
                    notebook.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
