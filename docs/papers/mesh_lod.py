#!/usr/bin/python3
"""Draws docs/papers/mesh_lod.svg, the experiment of Wang et al. 2009, Fig. 22 and 23: the force on a hand that slides over
the arch at 20, 60 and 150 mm/s, on one mesh, and on levels that switch at 30 and 120 mm/s, mapped and not.

    python3 docs/papers/mesh_lod.py build/release/typodont
"""
import csv
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SCENE = HERE.parents[1] / "assets/scenes/arch-explore.json"
MESH = HERE.parents[1] / "assets/jaw/lower_arch.ply"
SPEEDS = [20, 60, 150, 60, 20]  # mm/s, one pass each
LENGTH = 12.0  # mm of a pass, along x
DEPTH = 0.15  # mm of the hand below the surface
TIP = 0.125  # mm


def triangles():
    """The arch, mm."""
    data = MESH.read_bytes()
    header, body = data.split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in header.decode().splitlines() if line.startswith("element")]
    points = [struct.unpack_from("<3f", body, 12 * i) for i in range(counts[0])]
    for i in range(counts[1]):
        _, a, b, c = struct.unpack_from("<Biii", body, 12 * counts[0] + 13 * i)
        yield points[a], points[b], points[c]


def heights(y, xs):
    """Height of the surface above each (x, y), mm; None beside it."""
    top = [None] * len(xs)
    for p, q, r in triangles():
        if not min(p[1], q[1], r[1]) <= y <= max(p[1], q[1], r[1]):
            continue
        area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        if area <= 0:
            continue
        low, high = min(p[0], q[0], r[0]), max(p[0], q[0], r[0])
        for i, x in enumerate(xs):
            if not low <= x <= high:
                continue
            u = ((x - p[0]) * (r[1] - p[1]) - (y - p[1]) * (r[0] - p[0])) / area
            v = ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / area
            if u < 0 or v < 0 or u + v > 1:
                continue
            z = p[2] + u * (q[2] - p[2]) + v * (r[2] - p[2])
            top[i] = z if top[i] is None else max(top[i], z)
    return top


def smooth_line():
    """Of the lines along x the one on which the surface climbs least: (x, y, height) every 0.1 mm."""
    best, least = None, math.inf
    for k in range(25):
        y = -22 + 2.3 * k
        for start in (-15, -10, -5, 0, 5, 10, 15, 20):
            xs = [start + 0.1 * i for i in range(int(LENGTH / 0.1) + 1)]
            z = heights(y, xs[::10])
            if None in z or min(z) < 15:
                continue
            climb = max(abs(a - b) for a, b in zip(z, z[1:]))
            if climb < least:
                best, least = (y, xs), climb
    y, xs = best
    return [(x, y, z) for x, z in zip(xs, heights(y, xs))]


def hand(line):
    """Rows of the hand's file: down onto the line, then to and fro along it."""
    rows, t = [], 0.0
    x, y, z = line[0]

    def row(x, z):
        rows.append((t, x, y, z, 1, 0, 0, 0, 0))

    def at(s):
        i = min(int(s / 0.1), len(line) - 2)
        f = s / 0.1 - i
        a, b = line[i], line[i + 1]
        return a[0] + f * (b[0] - a[0]), a[2] + f * (b[2] - a[2]) + TIP - DEPTH

    for i in range(200):
        row(x, z + TIP + 1 - (1 + DEPTH) * i / 199)
        t += 1e-3
    for k, speed in enumerate(SPEEDS):
        s = 0.0
        while s < LENGTH:
            row(*at(s if k % 2 == 0 else LENGTH - s))
            t += 1e-3
            s += speed * 1e-3
    return rows


def run(program, folder, name, model, rows):
    scene = json.loads(SCENE.read_text())
    scene["model"] = {"mesh_lod": model}
    scene["passivity"] = scene["friction"] = False  # the force as the model makes it
    scene["tissue"]["mesh"]["file"] = str(MESH)
    scene["tissue"]["mesh"].pop("move_mm")  # the hand follows the file's own coordinates
    (folder / "scene.json").write_text(json.dumps(scene))
    with open(folder / "hand.csv", "w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow("t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal".split(","))
        writer.writerows(rows)
    table = folder / (name + ".csv")
    subprocess.run([program, "servo", folder / "scene.json", "--hand", folder / "hand.csv", "--out", table, "--no-timing"],
                   check=True, stdout=subprocess.DEVNULL)
    ticks = []
    with open(table) as source:
        for tick in csv.DictReader(source):
            force = [float(tick["force_%s_N" % axis]) for axis in "xyz"]
            ticks.append((float(tick["t_s"]), force, int(tick["level"])))
    return ticks


def switches(ticks):
    """The ticks in which the level changes."""
    return [i for i in range(1, len(ticks)) if ticks[i][2] != ticks[i - 1][2]]


def greatest_step(ticks, at):
    """The greatest change of force in these ticks, N."""
    return max((math.dist(ticks[i][1], ticks[i - 1][1]) for i in at), default=0.0)


def draw(runs, at, file):
    width, height, left, gap = 900, 150, 60, 40
    end = runs[0][1][-1][0]
    most = max(math.hypot(*f) for _, ticks in runs for _, f, _ in ticks)
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" font-family="sans-serif" font-size="12">'
             % (width + left + 20, len(runs) * (height + gap) + 30),
             '<rect width="100%" height="100%" fill="white"/>']
    shades = ["#ffffff", "#e8f0fb", "#cfe0f6"]
    for k, (name, ticks) in enumerate(runs):
        top = 20 + k * (height + gap)

        def x(t):
            return left + width * t / end

        def y(force):
            return top + height * (1 - force / most)

        start = 0
        for i in range(1, len(ticks) + 1):
            if i == len(ticks) or ticks[i][2] != ticks[start][2]:
                parts.append('<rect x="%.1f" y="%d" width="%.1f" height="%d" fill="%s"/>' % (
                    x(ticks[start][0]), top, x(ticks[i - 1][0]) - x(ticks[start][0]), height, shades[ticks[start][2] % 3]))
                start = i
        parts.append('<rect x="%d" y="%d" width="%d" height="%d" fill="none" stroke="#888"/>' % (left, top, width, height))
        points = " ".join("%.1f,%.1f" % (x(t), y(math.hypot(*f))) for t, f, _ in ticks)
        parts.append('<polyline points="%s" fill="none" stroke="#123a7a" stroke-width="1"/>' % points)
        parts.append('<text x="%d" y="%d">%s; greatest step in the ticks of a switch: %.3f N</text>' % (
            left, top - 5, name, greatest_step(ticks, at)))
        for force in (0, round(most, 1)):
            parts.append('<text x="%d" y="%.1f" text-anchor="end">%g N</text>' % (left - 5, y(force) + 4, force))
        for second in range(int(end) + 1):
            parts.append('<text x="%.1f" y="%d" text-anchor="middle">%d s</text>' % (x(second), top + height + 14, second))
    parts.append("</svg>\n")
    file.write_text("\n".join(parts))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    rows = hand(smooth_line())
    base = {"vertices": 143865, "levels": [33140, 13306, 7443], "switch_mm_s": [30, 120]}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        runs = [(title, run(sys.argv[1], folder, file, {**base, **more}, rows)) for title, file, more in (
            ("one mesh, 33,140 vertices", "one", {"levels": [33140]}),
            ("levels by speed, contact point mapped, ramped", "mapped", {}),
            ("levels by speed, not mapped", "unmapped", {"mapping": False}))]
    at = switches(runs[1][1])
    for title, ticks in runs:
        print("%-50s %d switches, greatest step in the ticks of a switch %.4f N" % (
            title, len(switches(ticks)), greatest_step(ticks, at)))
    draw(runs, at, HERE / "mesh_lod.svg")


if __name__ == "__main__":
    main()
