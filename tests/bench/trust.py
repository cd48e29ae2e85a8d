#!/usr/bin/python3
"""How reliable and valid a score is (docs/trust.md).

    trust.py simulate PROGRAM DOCS [PERSONS]   simulated cohorts of PERSONS (20) per group; writes DOCS/trust.md
    trust.py page DOCS                         the page again, from DOCS/trust/scores.csv
    trust.py analyse SCORES.csv                the figures of a study with people, from a table of their scores

SCORES.csv has the columns person, exercise, trial and points; optional: group, passed (1 or 0), and rater_1, rater_2 …
(points that teachers gave). `typodont rescore FOLDER --out SCORES.csv` writes a table that this script reads too: the
trainee is the person. Of a generated case, the family is the exercise and the seed the trial, and the first attempt
counts; of another scene, the trials are in the order of the dates. Add the columns of the raters to this table.
"""
import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

PASS = 75  # points, the program's default pass mark
EXERCISES, TRIALS = ["class-1", "class-5", "caries"], 4
# Limits of an acceptable cavity, mm: rubric rcampus PX4C443 for class I (floor 1.5 to 2 mm deep; of 1.8 mm of planned
# marginal ridge, at least 1.5 mm remain).
FLOOR, WALL = 0.25, 0.3
DEPTH = 1.75  # mm, middle of the rubric's depths
# Standard deviations of a student's errors. Position: 0.185 mm in all, a hand at the published limit of an ideal depth
# (72 % within 0.2 mm, SadidZadeh 2019); its three parts are an estimate. Tilt: half of the published deviation of total
# convergence, 11.7 degrees (Strain). Force: an estimate; dentists press with 0.34 to 1.03 N.
STUDENT = {"person_mm": 0.10, "trial_mm": 0.14, "spread_mm": 0.06, "tilt_deg": 5.9, "force_N": 1.0}
FACTOR = {"novice": 1.5, "student": 1.0, "expert": 0.5}  # on all errors; an estimate
SCALE_SD = 0.25  # of the logarithm of a person's factor within a group; an estimate
PRACTICE = math.log(55.48 / 52.90) / math.log(4)  # exponent: scores of 44.52 to 47.10 in four trials (Attahadi 2025)
RATER_ICC = 0.66  # of one teacher (Attahadi 2025)


# Statistics.

def shrout_fleiss(x):
    """Mean squares and intraclass correlations of a table, persons × trials (Shrout & Fleiss 1979)."""
    x = np.asarray(x, float)
    n, k = x.shape
    rows, columns, mean = x.mean(1), x.mean(0), x.mean()
    between = k * ((rows - mean) ** 2).sum() / (n - 1)
    trials = n * ((columns - mean) ** 2).sum() / (k - 1)
    within = ((x - rows[:, None]) ** 2).sum() / (n * (k - 1))
    error = ((x - rows[:, None] - columns + mean) ** 2).sum() / ((n - 1) * (k - 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        return {"1,1": (between - within) / (between + (k - 1) * within), "1,k": (between - within) / between,
                "2,1": (between - error) / (between + (k - 1) * error + k * (trials - error) / n),
                "2,k": (between - error) / (between + (trials - error) / n),
                "3,1": (between - error) / (between + (k - 1) * error), "3,k": (between - error) / between,
                "sem": math.sqrt(error)}


def trials_for(icc, wanted=0.8):
    """Number of trials whose mean has the wanted reliability (Spearman & Brown)."""
    return math.ceil(wanted * (1 - icc) / (icc * (1 - wanted)) - 1e-9) if icc > 0 else math.inf


def persons_for(icc, trials, width=0.2):
    """Persons for a 95 % interval of the ICC of this width (Bonett 2002)."""
    return math.ceil(8 * 1.96**2 * (1 - icc)**2 * (1 + (trials - 1) * icc)**2 / (trials * (trials - 1) * width**2) + 1)


def hedges_g(a, b):
    a, b = np.asarray(a, float), np.asarray(b, float)
    n = len(a) + len(b) - 2
    pooled = math.sqrt(((len(a) - 1) * a.var(ddof=1) + (len(b) - 1) * b.var(ddof=1)) / n)
    return (a.mean() - b.mean()) / pooled * (1 - 3 / (4 * n - 1))


def agreement(passed, acceptable):
    """Sensitivity (acceptable and passed) and specificity (not acceptable and failed)."""
    passed, acceptable = np.asarray(passed, bool), np.asarray(acceptable, bool)
    return (passed[acceptable].mean() if acceptable.any() else math.nan,
            (~passed[~acceptable]).mean() if (~acceptable).any() else math.nan)


def best_mark(points, acceptable, sensitivity=0.95):
    """The highest mark with this sensitivity, and its specificity."""
    points, acceptable = np.asarray(points, float), np.asarray(acceptable, bool)
    mark = np.sort(points[acceptable])[int((1 - sensitivity) * acceptable.sum() + 1e-9)]
    return mark, agreement(points >= mark, acceptable)[1]


def interval(persons, measure, times=1000):
    """Bootstrap interval (95 %) of a measure, over persons."""
    random = np.random.default_rng(1)
    some = [measure(random.integers(0, persons, persons)) for _ in range(times)]
    return np.nanpercentile(some, [2.5, 97.5])


# Tables.

def read(file):
    """Rows of a study. A table of `typodont rescore` gets the column names of this script."""
    with open(file, newline="", encoding="utf-8-sig") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    if rows and "trainee" in rows[0]:
        first, count = {}, {}
        for row in sorted((row for row in rows if not row.get("error")), key=lambda row: row["date"]):
            case = re.fullmatch(r"(.+)-(\d+)", row["scene"])
            row["person"], row["exercise"] = row["trainee"], case[1] if case else row["scene"]
            key = row["person"], row["exercise"]
            count[key] = count.get(key, 0) + 1
            row["trial"] = int(case[2]) if case else count[key]
            row["passed"] = {"true": "1", "false": "0"}.get(row["passed"], row["passed"])
            first.setdefault((*key, row["trial"]), row)
        rows = list(first.values())
    for number, row in enumerate(rows, 2):
        for name in ("person", "exercise", "trial", "points"):
            if row.get(name) in (None, ""):
                sys.exit(f"{file}: row {number}: no {name}")
        try:
            row["points"], row["trial"] = float(row["points"]), int(row["trial"])
            row["raters"] = [float(v) for k, v in row.items() if str(k).startswith("rater_") and v]
        except ValueError as error:
            sys.exit(f"{file}: row {number}: {error}")
        row["passed"] = row["passed"] == "1" if row.get("passed") else row["points"] >= PASS
    if not rows:
        sys.exit(f"{file}: no rows")
    return rows


def matrix(rows, value=lambda row: row["points"]):
    """Persons × trials; the mean over the exercises. Leaves out persons without all trials."""
    cells = {}
    for row in rows:
        cells.setdefault(row["person"], {}).setdefault(row["trial"], {})[row["exercise"]] = value(row)
    trials = sorted({row["trial"] for row in rows})
    count = len({row["exercise"] for row in rows})
    whole = {p: t for p, t in cells.items() if all(len(t.get(k, ())) == count for k in trials)}
    return np.array([[np.mean(list(t[k].values())) for k in trials] for t in whole.values()]).reshape(-1, len(trials))


def reliability(name, rows):
    x = matrix(rows)
    if x.shape[0] < 3 or x.shape[1] < 2:
        return [name, str(len(x)), *["–"] * 4]
    icc = shrout_fleiss(x)
    low, high = interval(len(x), lambda i: shrout_fleiss(x[i])["2,1"])
    need = trials_for(icc["2,1"])
    return [name, str(len(x)), f"{icc['2,1']:.2f} ({low:.2f} to {high:.2f})", f"{icc['3,k']:.2f}", f"{icc['sem']:.1f}",
            "–" if need == math.inf else str(need)]


def validity(name, rows, judge, decide=lambda row: row["passed"]):
    """One line of a table: decisions of the score against those of `judge`."""
    acceptable = [judge(row) for row in rows]
    ours = agreement([decide(row) for row in rows], acceptable)
    persons = sorted({row["person"] for row in rows})
    of = {p: [i for i, row in enumerate(rows) if row["person"] == p] for p in persons}

    def again(chosen):
        index = [i for c in chosen for i in of[persons[c]]]
        return agreement([decide(rows[i]) for i in index], [acceptable[i] for i in index])
    ends = [interval(len(persons), lambda c: again(c)[k], 500) for k in (0, 1)]
    cells = [f"{v:.2f} ({e[0]:.2f} to {e[1]:.2f})" for v, e in zip(ours, ends)]
    mark, specificity = best_mark([row["points"] for row in rows], acceptable) if any(acceptable) else (math.nan,) * 2
    return [name, f"{sum(acceptable)} of {len(rows)}", *cells, f"{specificity:.2f} at {mark:.0f} points"]


def panel(row):
    return np.mean(row["raters"]) >= PASS


def ranks(values):
    order = np.argsort(np.argsort(values))
    return order.astype(float)


HEAD_R = ["scores of", "persons", "ICC(2,1) (95 %)", "ICC(3,k)", "standard error, points", "trials for 0.8"]
HEAD_V = ["exercise", "acceptable", "sensitivity (95 %)", "specificity (95 %)", "specificity at sensitivity 0.95"]


def split(rows, key):
    return {value: [row for row in rows if row[key] == value] for value in dict.fromkeys(row[key] for row in rows)}


def tables(rows):
    """Reliability, and agreement with the raters, of any study."""
    exercises = split(rows, "exercise")
    lines = [reliability(name, some) for name, some in exercises.items()]
    if len(exercises) > 1:
        lines.append(reliability("their mean", rows))
    rated = [row for row in rows if len(row["raters"]) > 1]
    agrees = [validity(name, [r for r in some if len(r["raters"]) > 1], panel) for name, some in exercises.items()
              if any(len(r["raters"]) > 1 for r in some)]
    if rated and len(exercises) > 1:
        agrees.append(validity("all", rated, panel))
    return lines, agrees, rated


def raters_text(rated):
    icc = shrout_fleiss([row["raters"] for row in rated])
    mean = [np.mean(row["raters"]) for row in rated]
    points = [row["points"] for row in rated]
    pair = shrout_fleiss(np.column_stack([points, mean]))
    rho = np.corrcoef(ranks(points), ranks(mean))[0, 1]
    return (f"Raters: ICC(2,1) {icc['2,1']:.2f}, their mean {icc['2,k']:.2f}; score and panel: ICC(3,k) "
            f"{pair['3,k']:.2f}, Spearman's rho {rho:.2f}")


def analyse(file):
    rows = read(file)
    lines, agrees, rated = tables(rows)
    for head, some in ((HEAD_R, lines), (HEAD_V, agrees)):
        for cells in [head, *some] if some else []:
            print(" | ".join(cells))
    if rated:
        print(raters_text(rated))
    groups = {name: matrix(some).mean(1) for name, some in split(rows, "group").items()} if rows[0].get("group") else {}
    names = list(groups)
    for i, a in enumerate(names):
        for b in names[i + 1:]:
            print(f"{a} - {b}: Hedges' g {hedges_g(groups[a], groups[b]):.2f}")


# Simulated cohorts.

def cohort(persons):
    """Errors of each person's trials, as columns of `typodont case --hands`."""
    random = np.random.default_rng(67)
    rows = []
    for group, factor in FACTOR.items():
        for number in range(persons):
            own = factor * math.exp(random.normal(0, SCALE_SD))
            habit = own * STUDENT["person_mm"] * random.normal(size=3)
            force = STUDENT["force_N"] * own**0.5
            for exercise in EXERCISES:
                for trial in range(1, TRIALS + 1):
                    now = own * trial**-PRACTICE
                    x, y, z = habit + now * STUDENT["trial_mm"] * random.normal(size=3)
                    tilt = now * STUDENT["tilt_deg"] * random.normal(size=2)
                    pressed = force * math.exp(random.normal(0, 0.2))
                    rows.append({"person": f"{group}-{number + 1}", "group": group, "exercise": exercise,
                                 "trial": trial, "x_mm": x, "y_mm": y, "z_mm": z, "tilt_x_deg": tilt[0], "tilt_y_deg": tilt[1],
                                 "spread_mm": now * STUDENT["spread_mm"], "force_N": pressed,
                                 "force_max_N": 2.5 * pressed})
    return rows


HAND = ["x_mm", "y_mm", "z_mm", "tilt_x_deg", "tilt_y_deg", "spread_mm", "force_N", "force_max_N"]


def worst(row):
    """Largest planned error of floor and walls over its limit: 1 is the limit. Knows neither tissue nor score."""
    x, y, z, tilt_x, tilt_y, spread = (float(row[name]) for name in HAND[:6])
    wall = [abs(shift) + math.radians(abs(tilt)) * DEPTH / 2 for shift, tilt in ((x, tilt_y), (y, tilt_x))]
    return max((abs(z) + 2 * spread) / FLOOR, (max(wall) + 2 * spread) / WALL)


def perform(program, rows):
    """Scores all trials. Trial k of an exercise is the k-th valid case, the same one for every person."""
    with tempfile.TemporaryDirectory() as folder:
        hands = pathlib.Path(folder) / "hands.csv"
        for exercise in EXERCISES:
            seed = 0
            for trial in range(1, TRIALS + 1):
                some = [row for row in rows if row["exercise"] == exercise and row["trial"] == trial]
                with open(hands, "w") as out:
                    for cells in [HAND, *([f"{row[h]:.4f}" for h in HAND] for row in some)]:
                        print(",".join(cells), file=out)
                while True:
                    seed += 1
                    made = subprocess.run([program, "case", exercise, "--seed", str(seed), "--difficulty", "0",
                                           "--json", "--hands", str(hands), "--out", folder + "/case.json"],
                                          capture_output=True, text=True)
                    if made.returncode == 0:
                        break
                    if made.returncode != 1 or seed > 100:
                        sys.exit(made.stderr)
                for row, hand in zip(some, json.loads(made.stdout)["hands"]):
                    row.update(seed=seed, points=hand["points"], passed=int(hand["passed"]))
                print(exercise, trial, f"{np.mean([row['points'] for row in some]):.1f} points", flush=True)


def add_raters(rows):
    """Three simulated teachers: 100 - 25 · worst error, with noise that gives one teacher's published ICC."""
    random = np.random.default_rng(3)
    true = np.array([100 - 25 * worst(row) for row in rows])
    noise = math.sqrt(true.var() * (1 - RATER_ICC) / RATER_ICC)
    for row, grade in zip(rows, true):
        row.update({f"rater_{i + 1}": grade + noise * random.normal() for i in range(3)})


def simulate(program, docs, persons=20):
    rows = cohort(int(persons))
    perform(program, rows)
    store(rows, docs)


def store(rows, docs):
    add_raters(rows)
    stored = pathlib.Path(docs) / "trust/scores.csv"
    stored.parent.mkdir(parents=True, exist_ok=True)
    with open(stored, "w", newline="") as out:
        table = csv.DictWriter(out, rows[0].keys(), lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})
    page(docs)


# The page.

PUBLISHED = [("caries removal, 14 residents and 12 students (J Dent Educ 2014)", 0.81),
             ("crown, 10 experts and 10 novices (Rhienmora, Suebnukarn)", 0.94),
             ("caries block, 17 clinicians and 112 students (PMC8936553)", 0.52)]  # least g that gives p < .05

TEXT = """
# Can a score be trusted?

**All figures on this page are of simulated hands, not of people; the protocol below lets a school measure them with
people.** `./run trust` makes the hands and this page; [scores.csv](trust/scores.csv) contains every trial.

## The simulated hands

{persons} novices, {persons} students and {persons} experts did {trials} trials of each of three [exercises](cases.md),
every person the same cases. A hand follows the planned strokes, cut without a servo, with errors (standard deviations):

{parameters}

Cases have difficulty 0. From publications: the student's position is at the limit of a published criterion (72 % of the
depths within 0.2 mm; SadidZadeh 2019), the tilt is half of the deviation of total convergence (11.7°; Strain), and
practice lowers errors as in four trials of students (44.5 to 47.1 points; Attahadi 2025). The division into habit,
trial and stroke, the factors 1.5 and 0.5 of novices and experts, the deviation of a person's factor (25 %) and the
forces are estimates. Absolute errors of novices and experts are not published.

![Left: points against the largest planned error. Right: reliability against the number of trials](trust/trust.svg)

## Reliability

{reliability}

An ICC depends on how different the persons are, here on the estimates above. For comparison: the students' largest
planned errors, as their mean over the exercises, have an ICC(2,1) of {own}, the scores {score}. Students resemble each
other more than the three groups do, so they need more trials.

Means: {means}. Experts and novices differ by Hedges' g = {g}. Published studies state only p < 0.05, so their g is at
least: {published}.

## Sensitivity and specificity

A trial is acceptable if no planned error of floor (0.25 mm) or walls (0.3 mm) exceeds the limit of a public rubric
(class I, here for all exercises: floor 1.5 to 2 mm deep, at least 1.5 of 1.8 mm of marginal ridge left). The strokes'
ends count twice, the tilt over half of the depth. These errors are the input of the simulation, and know neither tissue
nor score. Limits and pass mark (75) were not fitted to each other.

{acceptable}

{verdict}

**No tested measure of the cut cavity reaches the aim** (figures of this paragraph: earlier teeth). One of the best
rules, not in the score: at most 0.1 mm² of the ideal floor is more than 0.25 mm from the surface, and at most 0.1 mm²
of the ideal walls more than 0.3 mm. A pass by this rule has a specificity of 0.85 at a sensitivity of 0.94. If such
rules (0.1 mm², 2 % or 5 % of the area) get their limits from half of the persons, they have 0.84 at 0.94 for the other
half, but 0.78 to 0.81 with one limit for floor and walls: most of the gain comes from the two limits that also define
an acceptable trial. 34 measures together, fitted to the planned errors of nine tenths of the persons, have at best 0.87
at 0.95 for the rest. The reason: a cavity is not what was planned. Of the 66 unacceptable trials that the rule would
pass, 33 are unacceptable only because the tilt is added to the displacement, although both may cancel, and 14 have a
floor planned too high, which other strokes deepen.

A session with a [critical error](tasks.md#what-can-be-scored) does not pass: here an over-cut of more than 0.35 mm (the
rule's target of 0.1 mm, and half of the rubric's range of depths; of several limits, the best on such trials), or an
opened pulp. By its points alone (75), the score would reach:

{also}

A published program reached 0.98 and 0.55 against a panel (ICC(3,k) 0.86, rho 0.73; PMC11330331). Three simulated
teachers give 100 points less 25 per limit of the worst error, with noise for the published ICC of one teacher (0.66).
Against their mean, the score reaches {ours}; the planned errors themselves reach only {ceiling}, so a panel's own
errors limit what can be measured. {raters}.

## Errors that a report names

In 96 recorded sessions with 340 injected errors (over-cuts of floor and walls of 0.4 to 0.6 mm, force, tissue left, an
opened pulp, a touched neighbour), the report named 336 (recall 0.99), and 337 of its 347 named strokes were right
(precision 0.97), within 0.2 s. `TYPODONT_STRESS=16 build/release/tests/property_defects` repeats them;
`TYPODONT_STRESS=84` makes 504 sessions.

## Protocol for a school

1. **Persons.** Students of at least two different years of study, and dentists. All give their consent, and have a code
   instead of a name. Number of students for a 95 % interval of the ICC that is 0.2 wide (Bonett 2002):

{sizes}

2. **Exercises.** `typodont case class-1 --seed 1 --difficulty 0 --out class-1-1.json`, the same for `class-5` and
   `caries` and for seeds 2 and 3. Every person does every case once, in random order, after another case for practice.
3. **Recording.** `typodont run CASE --trainee CODE --record FILE.h5`; each file is then
   [signed](integrity.md#signed-sessions). Nobody sees a score before the end of the study.
4. **Teachers.** At least three, each alone, grade every result (`typodont mesh`) from 0 to 100 by a rubric; 75 means
   acceptable. They know neither person, group nor score. They grade a tenth of the results twice.
5. **Analysis.** `typodont rescore FOLDER --out scores.csv`; add the columns `rater_1`, `rater_2` … and `group`. Then
   `tests/bench/trust.py analyse scores.csv` prints the tables of this page.
6. **Decision, fixed before the study.** Use the score in exams if sensitivity is at least 0.95 and specificity at least
   0.9 against the panel, and average as many trials as a reliability of 0.8 needs.
"""


def figure(file, rows, icc):
    from pages import COLORS, plt
    picture, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6))
    for color, (group, some) in zip(COLORS, split(rows, "group").items()):
        left.plot([worst(row) for row in some], [row["points"] for row in some], ".", ms=3, color=color, label=group,
                  rasterized=True)
    left.axhline(PASS, color="#999999", lw=0.7)
    left.axvline(1, color="#999999", lw=0.7)
    left.set(xlabel="largest planned error / limit", ylabel="points", xlim=(0, 4), ylim=(0, 100))
    left.legend(fontsize=8, frameon=False)
    count = np.arange(1, 13)
    for color, (name, value) in zip(COLORS, icc.items()):
        right.plot(count, count * value / (1 + (count - 1) * value), "o-", ms=3, color=color, label=name)
    right.axhline(0.8, color="#999999", lw=0.7)
    right.set(xlabel="trials", ylabel="reliability of their mean", ylim=(0, 1))
    right.legend(fontsize=8, frameon=False)
    picture.tight_layout()
    picture.savefig(file, metadata={"Date": None}, dpi=150)
    plt.close(picture)


def verdict(rows, within):
    sensitivity, specificity = agreement([row["passed"] for row in rows], [within(row) for row in rows])
    text = f"a specificity of 0.9 at a sensitivity of 0.95: a pass has {specificity:.2f} at {sensitivity:.2f}"
    if sensitivity >= 0.95 and specificity >= 0.9:
        return f"**The aim is reached,** {text}."
    wrong = [row for row in rows if row["passed"] and not within(row)]
    return (f"**The aim is not reached,** {text}. {len(wrong)} unacceptable trials pass; their worst error exceeds its "
            f"limit by {100 * (np.median([worst(row) for row in wrong]) - 1):.0f} % (median), and "
            f"{sum(float(row['z_mm']) < 0 for row in wrong)} of them cut too deep.")


def page(docs):
    from pages import number, paragraph, table
    docs = pathlib.Path(docs)
    rows = read(docs / "trust/scores.csv")
    groups = split(rows, "group")
    lines, _, rated = tables(rows)
    students, _, _ = tables(groups["student"])
    own = matrix(groups["student"], worst)
    icc = {"students": shrout_fleiss(matrix(groups["student"]))["2,1"], "all": shrout_fleiss(matrix(rows))["2,1"]}
    figure(docs / "trust/trust.svg", rows, icc)
    mean = {name: matrix(some).mean(1) for name, some in groups.items()}
    def within(row):
        return worst(row) <= 1

    def by_points(row):
        return row["points"] >= PASS
    exercises = split(rows, "exercise")
    clear = [row for row in rows if not 0.8 < worst(row) < 1.25]
    sets = [*exercises.items(), ("all", rows), ("all, without errors of 0.8 to 1.25 limits", clear)]
    acceptable = [validity(name, some, within)[:4] for name, some in sets]
    also = [validity(name, some, within, by_points) for name, some in sets]
    passed, true, graded = ([test(row) for row in rows] for test in
                            (lambda row: row["passed"], within, panel))
    ours, ceiling = agreement(passed, graded), agreement(true, graded)
    values = {
        "persons": str(len(mean["student"])), "trials": str(TRIALS),
        "parameters": table(["error", "novice", "student", "expert"], [
            [what, *(number(STUDENT[key] * factor**power) for factor in FACTOR.values())]
            for what, key, power in [("habit of a person, each axis, mm", "person_mm", 1),
                                 ("displacement of a trial, each axis, mm", "trial_mm", 1),
                                 ("end of a stroke, each axis, mm", "spread_mm", 1),
                                 ("tilt, each axis, degrees", "tilt_deg", 1), ("mean force, N", "force_N", 0.5)]]),
        "reliability": table(HEAD_R, [["all: " + line[0], *line[1:]] for line in lines] +
                             [["students: " + line[0], *line[1:]] for line in students]),
        "own": f"{shrout_fleiss(own)['2,1']:.2f}", "score": f"{icc['students']:.2f}",
        "means": ", ".join(f"{name}s {np.mean(v):.1f} (SD {np.std(v, ddof=1):.1f})" for name, v in mean.items()),
        "g": f"{hedges_g(mean['expert'], mean['novice']):.1f}",
        "published": "; ".join(f"{what}: {least}" for what, least in PUBLISHED),
        "acceptable": table(HEAD_V[:4], acceptable), "also": table(HEAD_V, also),
        "verdict": verdict(rows, within), "raters": raters_text(rated),
        "ours": f"{ours[0]:.2f} and {ours[1]:.2f}", "ceiling": f"{ceiling[0]:.2f} and {ceiling[1]:.2f}",
        "sizes": table(["expected ICC(2,1)", "2 trials", "3 trials", "4 trials"],
                       [[f"{r}", *(str(persons_for(r, k)) for k in (2, 3, 4))] for r in (0.5, 0.6, 0.7, 0.8)])}
    text = re.sub(r"\{(\w+)\}", lambda found: values[found[1]], TEXT)
    parts = [part if part.lstrip().startswith(("#", "|", "![", "1. ", "2. ")) else paragraph(part)
             for part in text.strip().split("\n\n")]
    (docs / "trust.md").write_text("\n\n".join(part.strip("\n") for part in parts) + "\n")
    print(f"wrote {docs / 'trust.md'}")


if __name__ == "__main__":
    commands = {"simulate": (simulate, 2, 3), "page": (lambda docs: page(docs), 1, 1), "analyse": (analyse, 1, 1)}
    call, least, most = commands.get(sys.argv[1] if len(sys.argv) > 1 else "", (None, 0, 0))
    if not call or not least <= len(sys.argv) - 2 <= most:
        sys.exit(__doc__)
    call(*sys.argv[2:])
