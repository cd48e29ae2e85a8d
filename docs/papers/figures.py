#!/usr/bin/python3
"""Draws figures of the papers from runs of the program, as SVG beside this file:

  vertex_filter.svg   S4, Fig. 7: force of vertex deformation on a hand that slides over the arch, filter off and on
  packing_rate.svg    S2: ticks a second by the number of spheres
  reaming_map         S2, Fig. 6 and 7, reaming_before.png and reaming_after.png: what should be removed from a hip
                      socket, and the difference from the ideal after the reaming (takes some minutes)
  drilling_sound.svg  S5: force, contact area and level of the AR(300) sound while a bur drills the molar

    python3 docs/papers/figures.py build/release/typodont [NAME …]
"""
import array
import base64
import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import wave

import mesh_lod

HERE = pathlib.Path(__file__).resolve().parent
ASSETS = HERE.parents[1] / "assets"
HAND = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal".split(",")
COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"]


def run(*arguments):
    subprocess.run([str(a) for a in arguments], check=True, stdout=subprocess.DEVNULL)


def servo(program, folder, scene, rows):
    """Ticks of the haptic core for a hand's rows, as dictionaries; and the file that they are in."""
    (folder / "scene.json").write_text(json.dumps(scene))
    with open(folder / "hand.csv", "w", newline="") as out:
        csv.writer(out).writerows([HAND] + rows)
    table = folder / "ticks.csv"
    run(program, "servo", folder / "scene.json", "--hand", folder / "hand.csv", "--out", table, "--no-timing")
    with open(table) as source:
        return [{k: float(v) for k, v in tick.items() if k != "tissue"} for tick in csv.DictReader(source)], table


class Drawing:
    """Panels below each other, linear axes, x common."""

    def __init__(self, x_label):
        self.x_label, self.panels = x_label, []

    def panel(self, title, y_label, curves, points=False, top=None):
        """curves: (name, [(x, y)])."""
        self.panels.append((title, y_label, curves, points, top))

    def write(self, file):
        width, height, left, gap = 820, 150, 66, 46
        xs = [x for _, _, curves, _, _ in self.panels for _, line in curves for x, _ in line]
        low, high = min(xs), max(xs)
        parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" font-family="sans-serif" font-size="12">'
                 % (width + left + 20, len(self.panels) * (height + gap) + 40),
                 '<rect width="100%" height="100%" fill="white"/>']
        for k, (title, y_label, curves, points, most) in enumerate(self.panels):
            top = 24 + k * (height + gap)
            most = most or 1.05 * max(y for _, line in curves for _, y in line) or 1

            def place(x, y):
                return "%.1f,%.1f" % (left + width * (x - low) / (high - low), top + height * (1 - min(y, most) / most))

            parts.append('<rect x="%d" y="%d" width="%d" height="%d" fill="none" stroke="#888"/>' % (left, top, width, height))
            parts.append('<text x="%d" y="%d">%s</text>' % (left, top - 6, title))
            parts.append('<text transform="translate(16 %d) rotate(-90)" text-anchor="middle">%s</text>' % (
                top + height / 2, y_label))
            for fraction in (0, 0.5, 1):
                parts.append('<text x="%d" y="%.1f" text-anchor="end">%.3g</text>' % (
                    left - 5, top + height * (1 - fraction) + 4, fraction * most))
                at = low + fraction * (high - low)
                parts.append('<text x="%.1f" y="%d" text-anchor="middle">%.4g</text>' % (
                    left + width * fraction, top + height + 15, at))
            for i, (name, line) in enumerate(curves):
                color = COLORS[i % len(COLORS)]
                parts.append('<polyline points="%s" fill="none" stroke="%s"/>' % (
                    " ".join(place(x, y) for x, y in line), color))
                if points:
                    parts += ['<circle cx="%s" cy="%s" r="4" fill="%s"/>' % (*place(x, y).split(","), color)
                              for x, y in line]
                if name:
                    parts.append('<text x="%d" y="%d" fill="%s" text-anchor="end">%s</text>' % (
                        left + width - 8, top + 16 + 15 * i, color, name))
        parts.append('<text x="%d" y="%d" text-anchor="middle">%s</text></svg>\n' % (
            left + width / 2, len(self.panels) * (height + gap) + 26, self.x_label))
        file.write_text("\n".join(parts))


def vertex_filter(program):
    """Ripple: rms of the force's change in a tick."""
    rows = [list(row) for row in mesh_lod.hand(mesh_lod.smooth_line())]
    drawing = Drawing("s")
    for title, force_filter in (("filter off", "none"), ("filter on", "stroke")):
        scene = json.loads((ASSETS / "scenes/arch-explore.json").read_text())
        scene["tissue"]["mesh"]["file"] = str(mesh_lod.MESH)
        scene["tissue"]["mesh"].pop("move_mm")  # the hand follows the file's own coordinates
        scene["model"], scene["force_filter"] = "vertex", force_filter
        scene["passivity"] = scene["friction"] = False  # the force as the model makes it
        with tempfile.TemporaryDirectory() as name:
            ticks, _ = servo(program, pathlib.Path(name), scene, rows)
        force = [(t["t_s"], math.hypot(t["force_x_N"], t["force_y_N"], t["force_z_N"])) for t in ticks]
        ripples = []
        for begin, end in ((0.3, 0.75), (0.0, math.inf)):
            steps = [b[1] - a[1] for a, b in zip(force, force[1:]) if begin < a[0] < end]
            ripples.append(1e3 * math.sqrt(sum(s * s for s in steps) / len(steps)))
        print("vertex_filter: %s, ripple %.2f mN a tick at 20 mm/s, %.1f mN over all speeds" % (title, *ripples))
        drawing.panel("%s: ripple %.2f mN a tick (rms) at 20 mm/s, until 0.8 s; then 60, 150, 60 and 20 mm/s" % (
            title, ripples[0]), "force, N", [("", force)])
    drawing.write(HERE / "vertex_filter.svg")


def packing_rate(_):
    """The rows of bench_methods in docs/performance/rows.csv."""
    with open(HERE.parent / "performance/rows.csv") as table:
        rows = {(r["case"], r["measure"]): float(r["value"])
                for r in csv.DictReader(line for line in table if not line.startswith("#"))}
    drawing = Drawing("thousand spheres")
    for title, case, measures in (("a round bur of 1.2 mm cuts", "cut a ball", ("time_ns", "slow_ns")),
                                  ("a reamer of 44 mm cuts", "ream a socket", ("mean_ns", "slow_ns"))):
        curves = []
        for measure in measures:
            ticks = [(n, rows["methods/packing/%d spheres/%s" % (n, case), measure]) for n in (10_000, 36_000, 300_000)]
            curves.append(({"time_ns": "median", "mean_ns": "mean", "slow_ns": "99.9 %"}[measure],
                           [(n / 1e3, 1e6 / ns) for n, ns in ticks]))
            print("packing_rate:", case, ", ".join("%.0fk spheres %.1f kHz" % p for p in curves[-1][1]))
        drawing.panel(title + ": ticks a second on one core (the paper: 1 kHz on average below 300,000 spheres, on two GPUs)",
                      "kHz", curves, points=True)
    drawing.write(HERE / "packing_rate.svg")


def reaming_map(program):
    """What should be removed before the reaming, and what differs from the ideal after it."""
    scene = ASSETS / "scenes/acetabular-reaming.json"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(program, "render", scene, "--view", "difference", "--rig", "hip", "--eye", "left", "--size", "420x320",
            "--out", folder)
        (folder / "left.png").replace(HERE / "reaming_before.png")
        session, page = folder / "session.h5", folder / "report.html"
        run(program, "servo", scene, "--model", "packing", "--hand", "expert:", "--out", session)
        run(program, "report", session, "--language", "en", "--out", page)
        draw_reaming_after(page)


def draw_reaming_after(page):
    picture = re.search(r'Difference from the ideal: At an angle" src="data:image/png;base64,([^"]*)"', page.read_text())
    (HERE / "reaming_after.png").write_bytes(base64.b64decode(picture[1]))


def drilling_sound(program):
    """A round bur touches a block three times, each time pressed harder: force, contact area and the sound's level."""
    scene = {"name": "block", "tool": "round_012", "spindle": "air_turbine", "parts": ["haptics", "sound"],
             "tissue": {"voxel_mm": 0.1, "solids": [
                 {"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]}}
    top, rows, t = 2.6, [], 0.0

    def go(seconds, x, low, high):
        nonlocal t
        steps = int(seconds * 1000)
        for i in range(steps):
            rows.append((t, x, 0, low + (high - low) * i / steps, 1, 0, 0, 0, 1))
            t += 1e-3

    for k, lead in enumerate((0.3, 0.6, 1.2)):  # mm ahead of the surface
        go(0.6, -2 + 2 * k, top + 0.5, top + 0.5)
        go(0.2, -2 + 2 * k, top + 0.5, top)
        go(0.8, -2 + 2 * k, top, top - lead)
        go(0.2, -2 + 2 * k, top - lead, top + 0.5)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        ticks, table = servo(program, folder, scene, rows)
        sound = folder / "drill.wav"
        run(program, "sound", "synth", ASSETS / "sounds/handpiece_ar300.json", "--seconds", "%.3f" % t, "--out", sound,
            "--contact", table)
        with wave.open(str(sound)) as source:
            rate, channels = source.getframerate(), source.getnchannels()
            samples = array.array("h", source.readframes(source.getnframes()))[::channels]
    window = rate // 50
    level = []
    for i in range(0, len(samples) - window, window):
        rms = math.sqrt(sum(s * s for s in samples[i:i + window]) / window) / 32768
        level.append(((i + window / 2) / rate, rms))
    drawing = Drawing("s")
    drawing.panel("force on the hand", "N", [("", [(k["t_s"], math.hypot(k["force_x_N"], k["force_y_N"], k["force_z_N"]))
                                                    for k in ticks])])
    drawing.panel("contact area", "mm²", [("", [(k["t_s"], k["contact_area_mm2"]) for k in ticks])])
    drawing.panel("level of the AR(300) sound, rms of 20 ms", "of full scale", [("", level)])
    drawing.write(HERE / "drilling_sound.svg")
    free = [v for s, v in level if 1.9 < s < 2.4]  # the turbine has run up
    work = [v for s, v in level if 5.0 < s < 5.2]
    print("drilling_sound: level %.3f free, %.3f in the third cut" % (
        sum(free) / len(free), sum(work) / max(len(work), 1)))


FIGURES = {"vertex_filter": vertex_filter, "packing_rate": packing_rate, "reaming_map": reaming_map,
           "drilling_sound": drilling_sound}


def main():
    if len(sys.argv) < 2 or any(name not in FIGURES for name in sys.argv[2:]):
        sys.exit(__doc__)
    for name in sys.argv[2:] or FIGURES:
        FIGURES[name](sys.argv[1])


if __name__ == "__main__":
    main()
