#!/usr/bin/python3
"""Writes docs/reality.md: cutting against published experiments.

    page.py RESULTS DOCS      RESULTS has reality.json of bench_reality; "-" uses DOCS/reality/rows.csv again
"""
import collections
import csv
import json
import math
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from pages import COLORS, collect, number, paragraph, plt, read_rows, table, write_rows  # noqa: E402

LANDING = ("at 180 N, much more than a hand's force, the limits that soften the landing of a drill (`teeth_fraction`) "
           "reduce the force on the cutting edges for part of the time")
REASONS = {
    "macor_speed": "in the simulation, the rate is proportional to the speed at a constant load; the source does not say what limits the rate",
    "enamel_carbide_energy": "the source states only that the energy per volume rises, so no constant is fitted",
    "leucite_ratio_heavy": "in the simulation, the ratio of the forces hardly depends on the load",
    "leucite_speed_drop": "the ceramic's ratio of the forces is an estimate",
    "artificial_energy_exponent": "the simulation uses the exponent of bone; the artificial femur is fitted at one speed",
    "electric_holds": "the source states no load; at 10 N, a diamond needs a torque of 3.0 N mm, but the motor holds its speed only up to 2.8 N mm",
    "femur_feed_1250": LANDING, "femur_feed_1500": LANDING,
    "wear_super_coarse": "in the simulation, wear is proportional to 1 / grain size; measured wear falls faster with grain size",
    "wear_20_cuts": "two studies of Macor disagree: a diamond's removal rate falls by 50 % over a cut of 39 mm in the first study, by 20 % over 220 mm in the second; the grinding ratio is fitted to the first",
    "polymer_jaw": "the source states no density; for the polymer, the simulation uses the constants of the artificial femur",
}
# Figures of the expert: bench_expert prints them, and tests bound them.
HANDS = "\n## Hands\n\n" + paragraph("""The simulated expert drills teeth with forces, contacts and tremor as measured in hands. A
    contact begins at 0.1 N, the smallest measured force.""") + "\n\n" + table(["quantity", "measured in hands", "expert"], [
        ["mean force in cavities", "0.34 to 1.03 N (J Oral Rehabil 22 (1995) 67-72)", "0.80 to 0.90 N"],
        ["mean force on axial walls of a crown", "1.71 N (PMID 17074189)", "1.62 N"],
        ["mean force on the occlusal surface of a crown", "0.45 N (PMID 17074189)", "0.49 N"],
        ["duration of a contact", "0.25 to 0.4 s, or 10 s (J Oral Rehabil 22 (1995) 67-72)", "0.33 to 0.35 s; crown 10 s"],
        ["contacts per second", "1.36 (temporal bone, PMID 34872376)", "1.36; crown 0.10"],
        ["force on an explorer, on sound teeth", "3.33 N, SD 2.14 N (Caries Res 37 (2003) 365)", "no expert; the score of an exploration takes off points above 3.33 N"],
        ["force on a condenser, of any width", "9.5 to 10.4 N (J Dent Res 1987, doi 10.1177/00220345870660030601)", "no force: filling exerts none"],
        ["tremor", "8.1 Hz (PMID 11568677), 38 µm rms (Riviere et al.)", "8.1 Hz, 38 µm rms"]]) + "\n" + paragraph(
    """With the measured force on the occlusal surface, the expert prepares a crown in 15 minutes. The expert trembles only while drilling: if
    hand instruments tremble too, the points in `amalgam-filling` fall from 96 to 88. For implant beds and hip sockets,
    the expert uses the forces that the exercises cite. The careless hand of [cases](cases.md#a-valid-case) repeats the
    expert's planned strokes at displaced positions and cuts regardless of forces.""") + "\n"
# Constants that are estimates: name, words in their source, and the experiment that would settle them.
ESTIMATES = [
    ("friction", "friction|all values", "draw the steel or diamond tool over wet tissue with 0.1 to 3 N; measure both forces"),
    ("cutting coefficient, efficiencies", "cutting coefficient|efficienc",
     "press side and end of one bur separately on a block; measure force, torque and rate"),
    ("law of chips", "exponent|grit:|blade:", "mill at a known depth with three feeds; torque × speed / volume"),
    ("specific energy", "specific energy|all values|as artificial", "mill at a known feed and depth; torque × speed / volume"),
    ("stiffness", "stiffness|all values", "let dentists match the rendered stiffness to specimens under the same tool"),
    ("colour", "colour|all values", "measure the diffuse reflectance of specimens"),
    ("density", "density|all values", "weigh specimens in air and water"),
    ("thickness of cortical bone by class", "thickness", "measure CT scans of each class"),
    ("conductivity, heat capacity", "as dentin|between cortical", "measure specimens (hot disk)"),
    ("cooling by the spray", "its reach|root of the flow", "measure a heated block under one handpiece at three flows"),
    ("flow and drops of the spray", "drops|flow:", "collect the water of one handpiece; laser diffraction"),
    ("torque by speed", "torque", "brake a named turbine from free speed to rest in 20 steps"),
    ("time of run-up", "run-up", "record the speed after a step of the pedal"),
    ("neck and length of the shank", "neck", "measure the named burs"),
    ("rate and reach of filling", "^rate|^reach", "weigh the portions that dentists place"),
    ("scraping", "scrapes", "draw a sharp excavator over carious and sound dentin; measure both forces"),
    ("yield of carious dentin", "yield", "press explorers into carious dentin; measure force and depth"),
]


def estimates(root):
    """Rows of the table of estimates: constants, files, experiment."""
    found = []

    def visit(value, where):
        for key, child in value.items() if isinstance(value, dict) else ():
            if key != "source":
                visit(child, where if key in ("classes", "tissues", "films", "spray") else [*where, key.replace("_", " ")])
                continue
            found.extend((part, " ".join(where)) for part in child.split("; ") if "(E)" in part)

    for folder in ("assets/materials", "assets/motors", "assets/tools"):
        for file in sorted((root / folder).glob("*.json")):
            value = json.loads(file.read_text())
            visit(value, [] if folder.endswith("materials") else [value["name"]])
    visit(json.loads((HERE / "materials.json").read_text()), [])
    for part, where in found:
        if not any(re.search(words, part) for _, words, _ in ESTIMATES):
            sys.exit(f"ESTIMATES has no experiment for \"{part}\" of {where}")
    for name, words, experiment in ESTIMATES:
        of = list(dict.fromkeys(where or "spray" for part, where in found if re.search(words, part)))
        yield name, "; ".join(of) if len(of) < 12 else f"{len(of)} tools", experiment


def bound(text, otherwise):
    return float(text) if text else otherwise


class Row:
    """An experiment with its simulated band."""

    def __init__(self, cells, band):
        self.__dict__.update(cells)
        self.accepted = bound(self.low, 0), bound(self.high, math.inf)
        self.band = (band["low"], band["high"]) if band else None

    def factor(self):
        """1: agrees; above: so many times too high; below: too low."""
        (low, high), (least, most) = self.band, self.accepted
        if high < least:
            return high / least
        return low / most if low > most else 1.0

    def verdict(self):
        factor = self.factor()
        if factor == 1:
            return "agrees"
        if factor > 1:
            return f"**{number(factor, 3)} × too high**"
        return f"**{number(1 / factor, 3)} × too low**" if factor > 0 else "**zero**"

    def limits(self):
        low, high = self.low or None, self.high or None
        return f"{low} to {high}" if low and high else f"at least {low}" if low else f"at most {high}"

    def simulated(self):
        low, high = (number(v, 3) for v in self.band)
        return low if low == high else f"{low} to {high}"

    def text_unit(self):
        return "" if self.unit == "-" else " " + {"C": "°C"}.get(self.unit, self.unit.replace("mm3", "mm³"))


def figure(file, title, rows):
    """Band of each row, divided by the middle of what is accepted."""
    picture, axes = plt.subplots(figsize=(7.2, 0.8 + 0.28 * len(rows)))
    for i, row in enumerate(reversed(rows)):
        low, high = row.accepted
        middle = float(row.measured or 0) or (math.sqrt(low * high) if 0 < low and high < math.inf else low or high)
        left, right = max(low / middle, 0.05), min(high / middle, 20)
        axes.plot([left, right], [i, i], color="#cccccc", lw=8, solid_capstyle="butt", zorder=1)
        simulated = [min(max(v / middle, 0.05), 20) for v in row.band]
        color = COLORS[2] if row.factor() == 1 else COLORS[1]
        axes.plot(simulated, [i, i], "|-", color=color, lw=2, ms=8, zorder=2)
    axes.set_yticks(range(len(rows)), [row.id.replace("_", " ") for row in reversed(rows)], fontsize=7)
    axes.set_xscale("log")
    axes.set_xlim(0.045, 22)
    axes.set_xticks([0.1, 0.2, 0.5, 1, 2, 5, 10], ["0.1", "0.2", "0.5", "1", "2", "5", "10"])
    axes.minorticks_off()
    axes.axvline(1, color="#999999", lw=0.5)
    axes.set(title=title, xlabel="simulated / measured; grey: accepted")
    picture.tight_layout()
    file.parent.mkdir(parents=True, exist_ok=True)
    picture.savefig(file, metadata={"Date": None})
    plt.close(picture)


def page(rows, origin, docs):
    with open(HERE / "experiments.csv", newline="") as lines:
        every = [Row(cells, rows.get(cells["id"])) for cells in csv.DictReader(lines)]
    groups = collections.defaultdict(list)
    for row in every:
        groups[row.process].append(row)
    tried = [row for row in every if row.band]
    agree = [row for row in tried if row.factor() == 1]
    far = [row for row in tried if row.factor() == 0 or not 0.5 <= row.factor() <= 2]
    text = "# Cutting against published experiments\n\n" + paragraph(
        f"""{len(agree)} of {len(tried)} simulated results agree with the published ones; {len(far)} {'differs' if
        len(far) == 1 else 'differ'} by more than a factor of two. {len(every) - len(tried)} more results are not
        simulated; `tests/bench/reality/experiments.csv` lists all results, and why some are not simulated. `./run bench reality`
        simulates most experiments with a machine that presses the tool on a slab with the published load, or moves it
        with the published feed. If a condition is unknown, the simulation tries both ends of its range. A row agrees if
        the simulated values overlap the accepted range. The accepted range is the published value ± two standard
        deviations if the source states them, otherwise ±35 % for rates and times, ±20 % for forces and ±2 K for temperatures. Constants of
        the program may be fitted to rows marked "fit", but not to rows marked "test". The letter after a source states
        its kind (A table or standard, B abstract, C secondary source, E estimate, F fitted to rows of this page).
        Simulated with: {origin}.""") + "\n"
    for process, some in groups.items():
        known = [row for row in some if row.band]
        if not known:
            continue
        name = process.replace(" ", "_")
        figure(docs / f"reality/{name}.svg", process.capitalize(), known)
        text += f"\n## {process.capitalize()}\n\n"
        text += f"![{process.capitalize()}: simulated / measured](reality/{name}.svg)\n\n"
        sources = ["", *(f"{row.source} ({row.quality})" for row in known)]
        text += table(["row", "experiment", "measured", "accepted", "simulated", "verdict", "use", "source"],
                      [[f"`{row.id}`", row.what, (row.measured or "–") + (row.text_unit() if row.measured else ""), row.limits(),
                        row.simulated() + row.text_unit(), row.verdict(), row.role, "same" if source == above else source]
                       for row, source, above in zip(known, sources[1:], sources)])
        because = collections.defaultdict(list)
        for row in known:
            if row.factor() != 1 and row.id in REASONS:
                because[REASONS[row.id]].append(f"`{row.id}`")
        reasons = [f"- {', '.join(some)}: {reason}." for reason, some in because.items()]
        if reasons:
            text += "\nWhy rows disagree:\n\n" + "\n".join(paragraph(r).replace("\n", "\n  ") for r in reasons) + "\n"
    return text + HANDS + "\n## Estimates\n\n" + paragraph(
        """These constants in `assets/materials/`, `assets/motors/`, `assets/tools/` and of this page's materials are
        estimates (E):""") + "\n\n" + table(
        ["constant", "of", "experiment that would measure it"], estimates(HERE.parents[2]))


def main(folder, docs):
    docs = pathlib.Path(docs)
    stored = docs / "reality/rows.csv"
    if folder != "-":
        write_rows(stored, *collect(pathlib.Path(folder), ["reality"], False))
    (docs / "reality.md").write_text(page(*read_rows(stored), docs))
    print(f"wrote {docs / 'reality.md'}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
