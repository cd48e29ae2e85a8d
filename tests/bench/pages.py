#!/usr/bin/python3
"""Writes pages with tables and plots from the results of the benchmark programs.

    pages.py RESULTS DOCS PAGE …      PAGE: performance, models, stress or stability

RESULTS has a file NAME.json of each program (google-benchmark). A page and its rows.csv and plots are written to DOCS.
All rows of a page must come from one machine and one commit. Without RESULTS ("-"), the rows.csv in DOCS is used again.
"""
import collections
import csv
import json
import math
import pathlib
import sys
import textwrap

import matplotlib
import matplotlib.ticker

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "typodont", "font.size": 9, "axes.spines.top": False,
                            "axes.spines.right": False, "svg.fonttype": "none"})
import matplotlib.pyplot as plt  # noqa: E402

PROGRAMS = ["contact", "motions", "push", "stability", "methods", "latency", "picture", "surface", "sound",
            "calibration", "session", "import", "device", "debris"]
COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#666666", "#000000"]
MARKERS = "osD^vPX*"
MODELS = ["offset", "implant", "mesh_lod", "packing", "vertex", "voxel_penalty"]


# Rows: {case: {measure: value}}, with the first line of the file, which names machine and commit.

def results(folder, program):
    """Reads what a program wrote. The case begins with the program's name on the page `performance`."""
    data = json.loads((folder / f"{program}.json").read_text())
    rows = {}
    for run in data["benchmarks"]:
        case = run["run_name"].removesuffix("/iterations:1/manual_time")
        row = rows.setdefault(case, {})
        if run["real_time"] > 0:
            row["time_ns"] = run["real_time"]
        standard = {"real_time", "cpu_time", "iterations", "threads", "repetitions", "repetition_index",
                    "family_index", "per_family_instance_index"}
        row.update({k: v for k, v in run.items() if isinstance(v, (int, float)) and k not in standard})
    context = data["context"]
    origin = (f"typodont {context['commit']}, {context['processor']}, {context['num_cpus']} cores, "
              f"{context['date'][:10]}, {context['compiler']}")
    return rows, origin, context["load_avg"][0] if context.get("load_avg") else math.nan


def collect(folder, programs, prefix):
    rows, origins, load, left_out = {}, set(), 0, []
    for program in programs:
        if not (folder / f"{program}.json").exists():
            left_out.append(program)
            continue
        some, origin, busy = results(folder, program)
        rows.update({f"{program}/{case}" if prefix else case: row for case, row in some.items()})
        origins.add(origin)
        load = max(load, busy)
    if len(origins) > 1:
        sys.exit("the rows come from several machines, days or commits; measure again:\n" + "\n".join(sorted(origins)))
    said = f"; not measured in this run: {', '.join(left_out)}" if left_out else ""
    return rows, f"{origins.pop()}; load average up to {load:.1f}{said}"


def write_rows(file, rows, origin):
    file.parent.mkdir(parents=True, exist_ok=True)
    with open(file, "w", newline="") as out:
        out.write(f"# {origin}\n")
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["case", "measure", "value"])
        for case, row in rows.items():
            for measure, value in row.items():
                table.writerow([case, measure, f"{value:.6g}"])


def read_rows(file):
    with open(file) as lines:
        text = list(lines)
    origin = text[0][2:].strip() if text[0].startswith("#") else ""
    rows = {}
    for row in csv.DictReader(line for line in text if not line.startswith("#")):
        rows.setdefault(row["case"], {})[row["measure"]] = float(row["value"])
    return rows, origin


# Texts.

def number(value, digits=2):
    """Rounds to some digits, without an exponent where it is readable."""
    if value is None or not math.isfinite(value):
        return "–"
    if abs(value) < 1e-12:
        return "0"
    if abs(value) < 1e-3 or abs(value) >= 1e5:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{value:.{max(digits - 1 - math.floor(math.log10(abs(value))), 0)}f}"


def time(ns):
    if not math.isfinite(ns):
        return "–"
    for unit, size in (("s", 1e9), ("ms", 1e6), ("µs", 1e3)):
        if ns >= 0.9995 * size:
            return f"{number(ns / size, 3 if ns / size >= 100 else 2)} {unit}"
    return f"{number(ns)} ns"


def times(row):
    """Median and 99.9 %."""
    return f"{time(row['time_ns'])} / {time(row['slow_ns'])}"


def paragraph(text):
    return textwrap.fill(" ".join(text.split()), 120, break_long_words=False, break_on_hyphens=False)


def table(head, lines):
    rows = [head, ["---"] * len(head), *lines]
    return "".join("|" + "|".join(cells) + "|\n" for cells in rows)


# Plots.

def plot(file, title, x_label, y_label, series, labels=False):
    """`series`: {name: [(x, y, label)]}. Both axes are logarithmic. Each point is one setting; better is lower left."""
    figure, axes = plt.subplots(figsize=(7.2, 4.2))
    for i, (name, points) in enumerate(series.items()):
        points = [(x, y, label) for x, y, label in points if x > 0 and y > 0]
        axes.plot([p[0] for p in points], [p[1] for p in points], MARKERS[i % 8] + "-", color=COLORS[i % 8], ms=5,
                  lw=1, label=name)
        for x, y, label in points if labels else []:
            axes.annotate(label, (x, y), textcoords="offset points", xytext=(5, 4), fontsize=7, color=COLORS[i % 8])
    axes.set_xscale("log")
    axes.set_yscale("log")
    ticks = matplotlib.ticker.FuncFormatter(lambda v, _: time(v) if x_label.startswith("time") else f"{v:g}")
    axes.xaxis.set(major_locator=matplotlib.ticker.LogLocator(subs=(1, 2, 5)), major_formatter=ticks,
                   minor_formatter=matplotlib.ticker.NullFormatter())
    axes.set(title=title, xlabel=x_label, ylabel=y_label)
    axes.grid(True, which="major", color="#dddddd", lw=0.5)
    axes.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    figure.tight_layout()
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)


def best(series):
    """For an alternative text: each method with its point of the least error."""
    said = []
    for name, points in series.items():
        x, y, _ = min(points, key=lambda p: p[1])
        said.append(f"{name} {number(y)}, {time(x)}")
    return "; ".join(said)


# The page `performance`.

def performance(rows, origin, docs):
    missing = collections.defaultdict(lambda: math.nan)  # a case that this run did not measure

    def get(case):
        return rows.get(case, missing)

    def ours(case):
        return times(get(case)) if "slow_ns" in get(case) else time(get(case)["time_ns"])

    def voxel(case):
        return get(f"contact/{case}/voxel 0.1 mm")

    presses = {case.split("/")[2]: row for case, row in rows.items()
               if case.startswith("contact/press/") and case.endswith("/voxel 0.1 mm")}
    hardest = max(presses, key=lambda place: presses[place]["direction_max_deg"], default="–")
    pressed = presses.get(hardest, missing)
    scans = {case.removeprefix("contact/slide on a scan/"): row for case, row in rows.items()
             if case.startswith("contact/slide on a scan/")}
    slowest_scan = max(scans, key=lambda case: scans[case]["slow_ns"], default="–")
    slide, penalty, field = voxel("slide/offset"), voxel("slide/voxel_penalty"), voxel("slide/penalty with OpenVDB")
    mesh = get("contact/slide/proxy on the offset mesh/edge 0.12 mm")
    drill = "contact/drill/round 1.2 mm/voxel 0.05 mm"
    sweep, csg = get("contact/removal/sweep/voxel 0.05 mm"), get(
        "contact/removal/csgDifference of OpenVDB/voxel 0.05 mm")
    motions = {case: row for case, row in rows.items() if case.startswith("motions/")}
    slowest = max(motions, key=lambda case: motions[case]["slow_ns"], default="motions/–/–")
    stalls = [row for case, row in rows.items() if case.startswith("stability/carver stalls/")]
    wall = get("stability/wall/delay of 0 ticks, jitter of 0 %/1000 Hz")
    push = next((row for case, row in rows.items() if case.startswith("push/") and case.endswith(" hands")), missing)
    whole = get("surface/molar/whole by volumeToMesh")
    frame = get("surface/molar/drilling frame/full resolution")
    ball = get("surface/ball at equal error")
    register = {name: get(f"calibration/register/{name}/16 touches") for name in ("typodont", "Eigen", "OpenCV")}
    camera = get("calibration/camera/12 pictures")
    sound, filtered = get("sound/drill, a sample/working in enamel"), get("sound/filter, a sample/order 300")
    record = get("session/record a tick with its cut/deflate 1")
    undo = get("session/undo a stroke of 16 passes, voxel 0.05 mm/cylinder_012")
    scan = get("import/CT of a head/512 x 512 x 140")
    start = get("latency/command to")
    soft = get("contact/soft gum/a ball presses")
    period = "1 ms"
    lines = [
        ["**where a trainee works**: rims, edges, corners, cusps and thin walls, balls of 1 to 10 mm, voxels of 0.1 mm "
         f"(worst place: {hardest})", f"{number(pressed['direction_median_deg'])}°, at most "
         f"{number(pressed['direction_max_deg'])}°; force {number(pressed['force_max_percent'])} %",
         f"{ours('contact/slide on a rim/voxel 0.1 mm')} (slide on a rim)",
         "[all contact models](models.md#where-a-trainee-works)", "0.2°, at most 2°; 1 ms"],
        [f"slide on a scanned molar and arch, five tools, 1 and 4 kHz (slowest: {slowest_scan.replace('/', ', ')})",
         f"force steps up to {number(max((row['step_beyond_motion_N'] for row in scans.values()), default=math.nan))} N "
         "beyond the hand's motion", ours(f"contact/slide on a scan/{slowest_scan}"), "–", "0.2 N; 1 ms"],
        ["slide on a ball, voxels of 0.1 mm", f"{number(slide['direction_max_deg'])}°", times(slide),
         f"penalty contact on OpenVDB's field (no proxy): {number(field['direction_max_deg'])}°, "
         f"{time(field['time_ns'])}; proxy on an offset mesh, as in CHAI3D: {number(mesh['direction_max_deg'])}°, "
         f"{time(mesh['time_ns'])}; voxel penalty: {number(penalty['direction_max_deg'])}°, "
         f"{time(penalty['time_ns'])}", period],
        ["a trainee drills dentin, round bur of 1.2 mm, voxels of 0.05 mm",
         f"{number(get(drill)['energy_error_rel'])} of the motor's work", ours(drill), "–", period],
        ["the same drilling, servo and carver together", "", f"{time(get(drill)['process_ns'])} (mean)", "–",
         period],
        ["the same drilling, round bur of 4 mm", "", ours("contact/drill/round 4 mm/voxel 0.05 mm"), "–", period],
        ["the same drilling, flame of 1.2 × 4 mm", "", ours("contact/drill/flame 1.2 x 4 mm/voxel 0.05 mm"), "–", period],
        ["one cut of a stroke, voxels of 0.05 mm", f"{number(sweep['volume_error_percent'])} % of the stroke's volume",
         time(sweep["time_ns"]),
         f"OpenVDB csgDifference: {number(csg['volume_error_percent'])} %, {time(csg['time_ns'])}", "–"],
        [f"slowest tick of all tools and motions ({slowest.split('/')[2]}, {slowest.split('/')[1].replace(' per s', '/s')})", "",
         ours(slowest), "–", "0.5 ms"],
        ["soft gum's part of a tick", "", times(soft), "–", period],
        ["stiffest stable wall at 1 kHz", f"{number(100 * abs(wall['servo_N_per_m'] / wall['theory_N_per_m'] - 1))} % from theory",
         f"{number(wall['servo_N_per_m'] / 1e3, 3)} N/mm", f"theory: {number(wall['theory_N_per_m'] / 1e3, 3)} N/mm",
         "–"],
        ["2,000 hands that push rotating tools (those that [start in tissue](passivity.md#force-steps-under-a-constant-push) are not counted)", f"{number(push['hands_beyond_motion'])} feel a force step larger than their motion explains",
         f"largest force step {number(push['largest_step_N'])} N", "–", "0 hands"],
        ["carver stalls of 0.05 to 5 s, compared with no stalls", f"force steps up to {number(max((r['step_beyond_calm_N'] for r in stalls), default=math.nan))} N larger",
         f"energy to the hand up to {number(max((r['energy_beyond_calm_mJ'] for r in stalls), default=math.nan))} mJ larger", "–", "0.25 N"],
        ["from an arm's sample to its force, in contact, 1 kHz", "", ours("device/sample to force, contact/1 kHz"), "–",
         period],
        ["motion to picture of 1280 × 720, drawn by the CPU, quality `fast`; `high`", "",
         f"{ours('latency/hand to picture, 1280x720/fast')}; {ours('latency/hand to picture, 1280x720/high')}", "–",
         "100 ms"],
        ["mesh update while drilling, molar in voxels of 0.05 mm", "the same triangles as the whole mesh", time(frame["mesh_ns"]),
         f"OpenVDB volumeToMesh of the whole molar: {time(whole['time_ns'])}", "33 ms"],
        ["mesh of a ball at equal error", f"{number(ball['error_of_radius'])} of the radius", time(ball["time_ns"]),
         f"volumeToMesh: {time(ball['volume_to_mesh_ns'])}", "–"],
        ["a sample of a working drill's sound", f"spectrum differs by {number(filtered['spectrum_error_dB'])} dB from the recording",
         f"{time(sound['time_ns'])} ({number(sound['core_percent'])} % of a core)",
         f"only the filter: simple loop {time(filtered['simple_loop_ns'])}, ours {time(filtered['time_ns'])}",
         "20.8 µs"],
        ["registration of arm and display from 16 touches", f"{number(register['typodont']['error_mm'])} mm",
         time(register["typodont"]["time_ns"]),
         "; ".join(f"{n}: {number(register[n]['error_mm'])} mm, {time(register[n]['time_ns'])}"
                   for n in ("Eigen", "OpenCV")), "–"],
        ["calibration of camera and panel from 12 pictures", f"{number(camera['focal_error_pixels'])} pixels of focal length",
         time(camera["time_ns"]), f"OpenCV: {number(camera['opencv_focal_error_pixels'])} pixels, "
         f"{time(camera['opencv_ns'])}", "–"],
        ["record a tick with its cut", f"{number(record['bytes'], 3)} bytes", time(record["time_ns"]), "–", period],
        ["undo a stroke of 16 passes", f"{number(undo['kept_kB'] / 1e3)} MB kept", time(undo["time_ns"]), "–", "100 ms"],
        ["import a CT of 512 × 512 × 140 voxels", f"{number(scan['peak_MB'], 3)} MB at most", f"{time(scan['time_ns'])} of CPU time",
         "–", "–"],
        ["live session, drilling, no picture", "",
         f"{number(get('latency/live session, a tick of all threads/drilling')['core_percent'])} % of a core", "–",
         "–"],
        ["from the command to the first tick", "", f"{number(start['first_tick_s'])} s", "–", "2 s"],
    ]
    page = "# Performance\n\n" + paragraph(
        f"""This page states time and error of a servo tick, a picture, a sound sample and a calibration, and compares them
        with the best other method in the same run. `./run bench` writes this page from
        [rows.csv](performance/rows.csv), which has more values. All values come from one machine and commit: {origin}.
        Other programs that run at the same time increase load average and 99.9 % quantiles. See also [contact models
        compared](models.md) and [stress tests](stress.md).""") + "\n\n"
    page += paragraph("""Two times in a cell are the median and the 99.9 % quantile of one thread's CPU time
        (of the arm: wall-clock time). After the time in the column "limit", a result is too late. A trainee is a
        simulated hand of 0.15 kg that presses the bur with 1 N, swings it by ±1.5 mm at 1 Hz, tilts it by 10° and
        trembles.""") + "\n\n"
    page += table(["work", "our error", "our time", "best other method", "limit"], [line for line in lines if "–" not in line[2]])
    page += "\n## Plots\n\n"
    page += paragraph("In each plot, a point is one setting; lower left is better (less error in less time).") + "\n"
    for name, title, x_label, y_label, series in performance_plots(rows):
        if not all(series.values()):
            continue  # not measured in this run
        plot(docs / f"performance/{name}.svg", title, x_label, y_label, series, labels=True)
        page += f"\n![{title}. Least {y_label} and its time: {best(series)}.](performance/{name}.svg)\n"
    return page


def performance_plots(rows):
    """Yields name, title, labels and points of each plot; times in ns."""
    def points(cases, error, time_of=lambda row: row["time_ns"]):
        return [(time_of(rows[case]), rows[case][error], label) for label, case in cases.items() if case in rows]

    voxels = {f"{v} mm": f"voxel {v} mm" for v in (0.2, 0.1, 0.05)}
    slides = {name: points({label: f"contact/slide/{name}/{v}" for label, v in voxels.items()}, "direction_max_deg")
              for name in ("offset", "voxel_penalty", "penalty with OpenVDB")}
    slides["proxy on the offset mesh"] = points(
        {f"{e} mm": f"contact/slide/proxy on the offset mesh/edge {e} mm" for e in (0.25, 0.12)}, "direction_max_deg")
    yield ("slide", "Slide on a ball: the direction of the force", "time of a tick", "error in degrees",
           slides)
    yield ("removal", "Remove a stroke: the volume", "time of a cut", "error in % of the volume", {
        name: points({label: f"contact/removal/{name}/{v}" for label, v in voxels.items()}, "volume_error_percent")
        for name in ("sweep", "csgDifference of OpenVDB", "voxels cleared")})
    yield ("register", "Registration: error at the corners of a cube of 80 mm", "time of a solution", "error in mm", {
        name: points({str(n): f"calibration/register/{name}/{n} touches" for n in (4, 16, 64, 1000)}, "error_mm")
        for name in ("typodont", "Eigen", "OpenCV")})
    frame = "picture/stereo frame of 1280x1024 an eye/"
    yield ("picture", "Picture: difference from the best quality level at twice the resolution", "time of a stereo frame, all threads",
           "difference (rms, of 255)", {"quality levels": points(
               {case.removeprefix(frame): case for case in rows if case.startswith(frame)}, "difference_rms_of_255")})
    orders = {str(n): f"sound/filter, a sample/order {n}" for n in (4, 16, 50, 100, 200, 300, 400, 600)}
    yield ("sound", "Sound of a drill: the spectrum against the recording", "time of a sample",
           "log-spectral distance in dB", {
               "block filter": points(orders, "spectrum_error_dB"),
               "simple loop": points(orders, "spectrum_error_dB", lambda row: row["simple_loop_ns"])})


# The page `models`.

TISSUES = ["ball", "torus", "box edges", "thin sheet", "groove", "molar", "arch", "pelvis"]
SHEETS = ["sheet of 0.2 mm", "sheet of 0.5 mm", "sheet of 1 mm"]
TASKS = [  # task, motion, measure, tissues, unit
    ("feel a smooth surface", "slide", "direction_rms_deg", ["ball", "torus"], "°"),
    ("feel edges, grooves and walls", "slide", "direction_rms_deg", ["box edges", "thin sheet", "groove"], "°"),
    ("feel a tooth from CT", "slide", "direction_rms_deg", ["molar"], "°"),
    ("feel the mesh of a scan", "slide", "direction_rms_deg", ["arch", "pelvis"], "°"),
    ("stick and slip with a probe", "drag", "friction_error_rms_percent", ["ball", "torus", "molar"], "% of friction"),
    ("drill solid tissue", "drill", "removal_error_percent", ["ball", "torus", "molar"], "% of the volume"),
    ("drill without steps of the force", "drill", "step_N", ["ball", "box edges", "molar"], "N per tick"),
    ("a short tick", "slide", "slow_ns", ["ball", "box edges", "molar"], "ns"),
    ("little memory", "slide", "memory_MiB", ["ball", "box edges", "molar"], "MiB"),
]


def finest(rows, motion, tissue, model):
    """The row of the model's finest setting, which is the last one, or None."""
    found = [row for case, row in rows.items() if case.startswith(f"{motion}/{tissue}/{model}/")]
    return found[-1] if found else None


def models(rows, origin, docs):
    def cell(motion, tissue, model, measure, scale=1.0):
        row = finest(rows, motion, tissue, model)
        return number(scale * row[measure]) if row and measure in row else "–"

    def answer():
        for task, motion, measure, tissues, unit in TASKS:
            means = {}
            for model in MODELS:
                some = [finest(rows, motion, t, model) for t in tissues]
                slide = [finest(rows, "slide", t, model) for t in tissues]
                if all(r and measure in r for r in some) and all(r and r["slow_ns"] < 5e5 for r in slide):
                    means[model] = math.exp(sum(math.log(max(r[measure], 1e-12)) for r in some) / len(some))
            value = {m: f"{number(means[m])} {unit}" if unit != "ns" else time(means[m]) for m in means}
            places = list(dict.fromkeys(value[m] for m in sorted(means, key=means.get)))  # models may share a place
            yield [task, *(cell for place in places[:2] for cell in (
                ", ".join(f"`{m}`" for m in means if value[m] == place), place))]

    def tables():
        for title, text, motion, measure, tissues, scale in (
                ("Direction of the force", f"""Angles between model force and exact force are in degrees (rms). A hand
                 slides the tool, a ball of 1.2 mm, at 20 mm/s; the hand is 0.3 mm below the exact contact. **On the
                 molar**, the force of `offset` differs by {cell("slide", "molar", "offset", "direction_rms_deg")}° (at
                 most {cell("slide", "molar", "offset", "direction_max_deg")}°) from the exact force of the triangle
                 mesh; on exact shapes by less.""", "slide", "direction_rms_deg", TISSUES, 1),
                ("Magnitude of the force", "Errors of the force's magnitude are in % of the exact magnitude (rms).", "slide",
                 "magnitude_rms_percent", TISSUES, 1),
                ("Depth in the tissue", "The table states the largest depth of the drawn tool (proxy) inside the exact shape, in mm.",
                 "slide", "penetration_mm", TISSUES, 1),
                ("Friction", """Errors of the ratio of tangential to normal force are in % of the exact ratio (rms). In the groove, two walls touch the tool, so the tool has no single normal.""", "drag",
                 "friction_error_rms_percent", TISSUES, 1),
                ("Removed volume", """Errors of the removed volume are in % of the swept volume. A simulated hand of
                 0.15 kg presses the bur with 1 N. A dash means that the bur fell through the tissue.""", "drill", "removal_error_percent",
                 [t for t in TISSUES if t != "thin sheet"], 1),
                ("Slow ticks", "Times are the 99.9 % quantile of a tick's CPU time in µs while the tool slides.", "slide",
                 "slow_ns", TISSUES, 1e-3),
                ("Slow ticks while drilling", "Times are the 99.9 % quantile of a tick's CPU time in µs while the bur drills.", "drill", "slow_ns",
                 [t for t in TISSUES if t != "thin sheet"], 1e-3)):
            lines = [[f"`{m}`", *(cell(motion, t, m, measure, scale) for t in tissues)] for m in MODELS]
            yield f"## {title}\n\n{paragraph(text)}\n\n{table(['model', *tissues], lines)}\n"

    series = {m: [(row["time_ns"], row["direction_rms_deg"], case.split("/")[3]) for case, row in rows.items()
                  if case.startswith(f"slide/groove/{m}/")] for m in MODELS}
    peers, _ = read_rows(docs / "models/peers.csv")
    series["CHAI3D"] = [(row["time_ns"], row["direction_rms_deg"], case.split("/")[3]) for case, row in peers.items()
                        if case.startswith("slide/groove/CHAI3D finger proxy/")]
    title = "Slide across a groove of 60°: direction error against time"
    plot(docs / "models/direction.svg", title, "time of a tick", "error, degrees rms", series)
    page = "# Contact models compared\n\n" + paragraph(
        """Use the contact model `offset`, the default, unless this table names a better model for your task. The best
        model has the smallest error, time or memory. The table leaves out models with ticks (passes of the servo loop)
        over 500 µs (99.9 % quantile). Each value in the table is the geometric mean over the task's tissues, at the
        model's finest setting. Outside an implant bed (drilled hole), `implant` slides and drills like `offset`.""") + "\n\n"
    page += table(["task", "best", "value of the best", "second", "value of the second"], list(answer())) + "\n"
    page += paragraph(
        f"""All models get the same tissue, simulated hand and servo rate (1 kHz). The exact contact is the tool's
        position outside the exact shape that is nearest to the hand (sequential quadratic programming,
        `tests/support/reference_contact.h`). A ball of 8 mm, a torus, a box, a sheet of 0.3 mm and a groove of 60° have
        an exact shape. The molar is from a CT scan; the molar's exact shape is the triangle mesh of its distance field.
        Lower arch and hip socket ("pelvis") are meshes; models without a mesh get voxels of 0.2 or 0.3
        mm. So the columns "molar", "arch" and "pelvis" favour models that use a mesh. The tables of direction and
        magnitude use the model's force, before the servo's limits; other tables use the servo's output. `./run bench models`
        writes this page from [rows.csv](models/rows.csv), which has more settings and values. Measured on: {origin}.""") + "\n\n"
    page += f"![{title}. Least error in degrees, and time: {best(series)}](models/direction.svg)\n\n"
    page += "".join(tables())
    presses = {}
    for case, row in rows.items():
        if case.startswith("press/"):
            presses.setdefault(case.split("/")[1], {})[case.split("/")[2]] = row
    if presses:
        page += "## Where a trainee works\n\n" + paragraph(
            """A hand presses a ball 0.2 mm deep at random places or in random directions. Angles between force and
            exact force are in degrees: median / largest.""") + "\n\n"
        page += table(["place", *(f"`{m}`" for m in MODELS)], [[place, *(
            f"{number(by[m]['direction_median_deg'])} / {number(by[m]['direction_max_deg'])}" for m in MODELS)]
            for place, by in presses.items()]) + "\n"
    walls = [[f"`{m}`", *(number(rows[f"break-through/thin sheet/{m}"].get(k)) for k in ("time_s", "force_left_N")),
              *(number(rows[f"escape/{s}/{m}"][k]) for s in SHEETS for k in ("escaped_1mm_percent",
                                                                          "escaped_20mm_percent"))] for m in MODELS]
    page += "## Walls\n\n" + paragraph(
        """A bur drills through the sheet of 0.3 mm; the first columns state the time until the breakthrough, and the
        largest force after it. Hands move through sheets of 0.2, 0.5 and 1 mm, by 1 or 20 mm per tick; the other
        columns state the % of hands that escape (no force pulls them back). The sheets for these hands are 14 mm wide,
        so no hand goes around the edge.""") + "\n\n"
    page += table(["model", "time, s", "force behind, N", *(f"{s.split()[2]} mm, by {k} mm" for s in SHEETS for k in (1, 20))],
                  walls)
    surfaces = {case.split("/")[-1]: row for case, row in rows.items() if case.startswith("surface/ball/offset/")}
    if surfaces:
        page += "\n## Intermediate surface\n\n" + paragraph(
            """A hand drills the ball. The hand feels the tissue of each tick, or the [intermediate
            surface](contact.md#intermediate-surface), which moves gradually ("blended") or jumps 30 times per
            second ("at once"). Cells state the largest change of the model's force in a tick (N), the lag of the felt surface (median
            and largest, mm), the removal (mm³) and the time of a tick.""") + "\n\n"
        page += table(["felt", "step", "lag", "at most", "removal", "time"], [[name, *(
            number(row[k]) for k in ("model_step_N", "lag_median_mm", "lag_max_mm", "removed_mm3")), times(row)]
            for name, row in surfaces.items()])
    costs = [[f"`{m}`", *(cell("slide", t, m, k) for t in ("ball", "molar") for k in ("memory_MiB", "setup_s"))]
             for m in MODELS]
    page += "\n## Memory and set-up\n\nMemory is in MiB; the CPU time that prepares the model is in s.\n\n" + table(
        ["model", *(f"{t}, {k}" for t in ("ball", "molar") for k in ("MiB", "s"))], costs)
    page += "\n## Other libraries\n\n" + paragraph(
        """CHAI3D 3.3.0 and `offset` get the same hand and voxels of 0.1 mm. Errors of the direction are in degrees
        (rms), times are the median of a tick. CHAI3D was measured in another run ([how](../tests/peers/README.md),
        [peers.csv](models/peers.csv)).""") + "\n\n"
    tissues = [t for t in TISSUES if f"slide/{t}/CHAI3D finger proxy/voxel 0.1 mm" in peers]
    page += table(["library", *tissues], [[name, *(
        f"{number(r['direction_rms_deg'])}, {time(r['time_ns'])}"
        for r in (some[f"slide/{t}/{name}/voxel 0.1 mm"] for t in tissues))]
        for name, some in (("CHAI3D finger proxy", peers), ("CHAI3D voxels", peers), ("offset", rows))])
    return page


# The page `stress`.

CAMPAIGNS = {
    "hostile hand": "random hands move at up to 0.2 m/s and 20 m/s² and rotate; half of them drill",
    "nonsense": "the hands of \"hostile hand\" get invalid input in one tick of fifty: NaN, jumps of hand or clock, "
                "undo",
    "carver stalls": "hands slide, drill and tap while the carver (tissue thread) stalls for 50 ms to 3 s",
    "uneven clock": "the hands of \"carver stalls\" move without stalls; the length of a tick differs from 1 ms by up to 20 "
                    "or 50 %, one tick in a hundred lasts 5 ms",
    "200 N": "a hand presses a head of 20 mm on bone with 200 N, and slides or reams",
    "fast probe": "a tip of 0.25 mm slides over edges, a groove and the dental arch at 30 to 120 mm/s",
    "thin wall": "hands move a ball through a sheet of 0.3 mm, by 1 mm per tick",
}
FAILS = {"not_finite_ticks", "beyond_limit_N", "hands_through", "escaped_percent", "holes_ticks"}
MEASURES = {
    "hands_through": "{} hands passed through the tissue", "escaped_percent": "{} % of the hands escaped",
    "step_beyond_calm_N": "a force step was {} N larger than without stalls",
    "energy_nJ": "the hand received {} nJ", "force_error_percent": "the force error was {} %",
    "holes_ticks": "{} ticks inside the tissue had no force", "not_finite_ticks": "{} ticks had a force that is not finite",
    "beyond_limit_N": "the force was {} N above its limit",
}
REASONS = {
    ("offset", "fast probe"): "at the fissures of the dental arch, the hand reverses direction faster than the passivity "
                              "controller predicts; the force there is 0.06 N",
    ("voxel_penalty", "thin wall"): "without a proxy, no force pulls back a hand behind the sheet",
    ("voxel_penalty", "fast probe"): "voxels of 0.1 or 0.2 mm are too coarse for a tip that is 0.06 mm deep",
    ("voxel_penalty", "carver stalls"): "the model `voxel_penalty` has no tissue outside the servo's tissue patch, and "
                                        "no plane of the last contact",
    ("packing", "fast probe"): "the gaps between the 10,000 spheres are as wide as the tip",
}
REASONS["implant", "fast probe"] = REASONS["offset", "fast probe"]


def stress(rows, origin, _):
    def broken(row):
        return [m.removesuffix(".limit") for m in row if m.endswith(".limit")
                and row[m.removesuffix(".limit")] > row[m] * (1 + 1e-9)]

    lines, failures = [], {}  # failures: models by what fails
    for campaign in CAMPAIGNS:
        cells = []
        for model in MODELS:
            row = rows[f"{campaign}/{model}"]
            worst = broken(row)
            cells.append("survives" if not worst else ("**fails**" if FAILS & set(worst) else "flawed"))
            if worst:
                values = ", ".join(f"{MEASURES[m].format(f'{row[m]:.{3 if row[m] < 1e3 else 4}g}')} (limit {row[m + '.limit']:g})"
                                   for m in worst)
                reason = REASONS.get((model, campaign))
                what = f"{campaign}: {values}." + (f" Reason: {reason}." if reason else "")
                failures.setdefault(what, []).append(f"`{model}`")
        lines.append([campaign, *cells])
    page = "# What each contact model survives\n\n" + table(["campaign", *(f"`{m}`" for m in MODELS)], lines) + "\n"
    page += paragraph(
        """- **Survives**: every measured value is within its limit.""") + "\n" + paragraph(
        """- **Flawed**: the model's force is finite and stops the hand, but gives the hand more than 1 nJ, has a large
        error, or has steps more than 0.25 N larger than without stalls.""").replace("\n", "\n  ") + "\n" + paragraph(
        """- **Fails**: the model's force is not finite, exceeds its limit or is missing inside the tissue, or the hand
        passes through the tissue.""").replace("\n", "\n  ") + "\n\n"
    page += paragraph(f"""`./run bench stress` writes this page from [rows.csv](stress/rows.csv), which contains every
        value with its limit. A test runs shortened campaigns with `offset` and `voxel_penalty`. Measured on:
        {origin}.""") + "\n\n## Campaigns\n\n"
    page += "".join(paragraph(f"- **{name}**: {what}.").replace("\n", "\n  ") + "\n" for name, what in CAMPAIGNS.items())
    return page + "\n## What fails, and why\n\n" + "".join(
        paragraph(f"- {', '.join(models)}, {what}").replace("\n", "\n  ") + "\n" for what, models in failures.items())


# The page `stability` of ./run stress.

def stability(rows, origin, docs):
    walls = {tuple(case.split("/")[1:]): row for case, row in rows.items() if case.startswith("wall/")}
    kinds = sorted({kind for kind, _ in walls})
    series = {}
    for kind in kinds:
        points = sorted((float(hz.split()[0]), row) for (k, hz), row in walls.items() if k == kind)
        series[f"servo, {kind}"] = [(hz, row["servo_N_per_m"], "") for hz, row in points]
        series[f"theory, {kind}"] = [(hz, row["theory_N_per_m"], "") for hz, row in points]
    plot(docs / "stability.svg", "Critical stiffness of a wall", "servo rate, Hz", "stiffness, N/m", series)
    lines = [[kind, hz, number(row["theory_N_per_m"], 3), number(row["servo_N_per_m"], 3)]
             for (kind, hz), row in walls.items()]
    page = f"# Map of stability\n\nMeasured on: {origin}.\n\n![Critical stiffness of the servo and of theory](stability.svg)\n\n"
    page += table(["timing", "rate", "theory, N/m", "servo, N/m"], lines)
    stalls = [[*case.split("/")[1:], number(row["step_beyond_calm_N"]), number(row["energy_beyond_calm_mJ"])]
              for case, row in rows.items() if case.startswith("carver stalls/")]
    return page + "\n" + table(["gesture", "stall of the carver", "step, N", "energy, mJ"], stalls)


PAGES = {"performance": performance, "models": models, "stress": stress, "stability": stability}


def main(folder, docs, *names):
    docs = pathlib.Path(docs)
    for name in names:
        stored = docs / ("stability.csv" if name == "stability" else f"{name}/rows.csv")
        if folder != "-":
            performs = name == "performance"
            write_rows(stored, *collect(pathlib.Path(folder), PROGRAMS if performs else [name], performs))
        rows, origin = read_rows(stored)
        (docs / f"{name}.md").write_text(PAGES[name](rows, origin, docs))
        print(f"wrote {docs / name}.md")


if __name__ == "__main__":
    if len(sys.argv) < 4 or not set(sys.argv[3:]) <= set(PAGES):
        sys.exit(__doc__)
    main(*sys.argv[1:])
