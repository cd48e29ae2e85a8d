#!/usr/bin/python3
"""Draws docs/papers/implant.svg, the experiment of Zhao et al. 2020, Fig. 12: the force on the hand in the 16 phases of
an implant of 4.8 x 12 mm, here of the scripted expert.

    python3 docs/papers/implant.py build/release/typodont
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import h5py

HERE = pathlib.Path(__file__).resolve().parent
SCENE = HERE.parents[1] / "assets/scenes/implant-premolar.json"
PANELS = (("A: round burs, phases 1 to 3", 0, 3), ("B: pilot drill and gauges, phases 4 to 7", 3, 7),
          ("C: twist drills and gauges, phases 8 to 13", 7, 13), ("D: tap, implant and closure screw, phases 14 to 16", 13, 16))
LINES = (("along the arch", "#2a7f3f"), ("along the plan's axis", "#123a7a"), ("across the arch", "#b5541c"))
BINS = 450  # of a panel: each shows the mean and the extremes of its ticks


def axes(scene):
    """Unit vectors: along the arch, out of the bone along the plan's axis, across."""
    a = scene["implant"]["plan"]["axis"]
    length = sum(v * v for v in a) ** 0.5
    out = [-v / length for v in a]
    along = [1.0, 0.0, 0.0]
    across = [out[1] * along[2] - out[2] * along[1], out[2] * along[0] - out[0] * along[2],
              out[0] * along[1] - out[1] * along[0]]
    return along, out, across


def session(program, folder):
    """The phases of the report, and the ticks: (t, three forces)."""
    scene = json.loads(SCENE.read_text())
    recording = folder / "expert.h5"
    subprocess.run([program, "servo", SCENE, "--hand", "expert:", "--out", recording, "--no-timing"], check=True,
                   stdout=subprocess.DEVNULL)
    said = subprocess.run([program, "report", recording, "--out", folder / "expert.html", "--json"], check=True,
                          capture_output=True, text=True).stdout
    report = json.loads(said)
    directions = axes(scene)
    with h5py.File(recording, "r") as f:
        columns = [f["ticks"][name][:] for name in ("t_s", "force_x_N", "force_y_N", "force_z_N")]
    ticks = [(t, [sum(f * d for f, d in zip(force, way)) for way in directions])
             for t, *force in zip(*(column.tolist() for column in columns))]
    return report, ticks


def draw(report, ticks, file):
    width, height, left, gap = 900, 170, 60, 50
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" font-family="sans-serif" font-size="12">'
             % (width + left + 20, len(PANELS) * (height + gap) + 40), '<rect width="100%" height="100%" fill="white"/>']
    for k, (name, color) in enumerate(LINES):
        parts.append('<text x="%d" y="16" fill="%s">%s</text>' % (left + 180 * k, color, name))
    phases = report["phases"]
    for k, (title, first, end) in enumerate(PANELS):
        top = 44 + k * (height + gap)
        shown = [(i, p) for i, p in enumerate(phases[first:end], first) if p["began_s"] is not None]
        t0, t1 = shown[0][1]["began_s"], (shown[-1][1]["ended_s"] or ticks[-1][0]) + 1
        inside = [tick for tick in ticks if t0 <= tick[0] <= t1]
        low = min(min(f) for _, f in inside)
        high = max(max(f) for _, f in inside)

        def x(t):
            return left + width * (t - t0) / (t1 - t0)

        def y(force):
            return top + height * (high - force) / (high - low)

        for n, (i, phase) in enumerate(shown):
            until = shown[n + 1][1]["began_s"] if n + 1 < len(shown) else t1
            if n % 2 == 0:
                parts.append('<rect x="%.1f" y="%d" width="%.1f" height="%d" fill="#eef2f8"/>' % (
                    x(phase["began_s"]), top, x(until) - x(phase["began_s"]), height))
            parts.append('<text x="%.1f" y="%d" fill="#555">%d</text>' % (x(phase["began_s"]) + 2, top + 12, i + 1))
        for axis, (_, color) in enumerate(LINES):
            bins = [[] for _ in range(BINS)]
            for t, force in inside:
                bins[min(BINS - 1, int(BINS * (t - t0) / (t1 - t0)))].append(force[axis])
            points = []
            for b, values in enumerate(bins):
                at = x(t0 + (b + 0.5) * (t1 - t0) / BINS)
                if values:
                    points.append("%.1f,%.1f %.1f,%.1f" % (at, y(min(values)), at, y(max(values))))
            parts.append('<polyline points="%s" fill="none" stroke="%s" stroke-width="0.8"/>' % (" ".join(points), color))
        parts.append('<rect x="%d" y="%d" width="%d" height="%d" fill="none" stroke="#888"/>' % (left, top, width, height))
        parts.append('<text x="%d" y="%d">%s</text>' % (left, top - 5, title))
        for force in (low, 0, high):
            parts.append('<text x="%d" y="%.1f" text-anchor="end">%.1f N</text>' % (left - 5, y(force) + 4, force))
        parts.append('<text x="%d" y="%d">%.0f s</text><text x="%d" y="%d" text-anchor="end">%.0f s</text>' % (
            left, top + height + 14, t0, left + width, top + height + 14, t1))
    parts.append("</svg>\n")
    file.write_text("\n".join(parts))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as name:
        report, ticks = session(sys.argv[1], pathlib.Path(name))
    for i, phase in enumerate(report["phases"]):
        print("%2d %-45s %s, greatest force %5.2f N, depth %5.2f mm" % (
            i + 1, phase["name"], "done" if phase["done"] else "open", phase["force_max_N"], phase["depth_mm"]))
    draw(report, ticks, HERE / "implant.svg")


if __name__ == "__main__":
    main()
