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

LANDING = ("at 180 N, far above a hand's forces, the limits that soften the landing of a drill (`teeth_fraction`) take the "
           "pressing force from the edges for part of the time")
REASONS = {
    "macor_speed": "the rate is proportional to the speed at a constant load; the experiments do not say what limits it",
    "enamel_carbide_energy": "only the sign is published, so there is nothing to fit",
    "leucite_ratio_heavy": "the ratio of the forces does not depend on the load",
    "leucite_speed_drop": "the energy per volume of the ceramic and the ratio of the forces are estimates",
    "artificial_energy_exponent": "the exponent is that of bone; the artificial femur has one fitted speed",
    "electric_holds": "the load is not stated; a diamond at 10 N needs 3.0 N mm, the motor holds its speed up to 2.8",
    "femur_feed_1250": LANDING, "femur_feed_1500": LANDING,
    "wear_super_coarse": "the law makes the wear proportional to 1 / grain size; measured, it falls faster with the size",
    "wear_20_cuts": "the two studies of Macor disagree: -50 % over 39 mm, -20 % over 220 mm; the grinding ratio is fitted to the first",
    "polymer_jaw": "the jaw's density is not stated; the simulation takes that of the artificial femur",
}
# Figures of the expert: bench_expert prints them, and tests bound them.
HANDS = "\n## Hands\n\n" + paragraph("""The simulated expert drills teeth as measured in hands. Contact: 0.1 N or more, the
    least that was measured.""") + "\n\n" + table(["quantity", "measured in hands", "expert"], [
        ["mean force in cavities", "0.34 to 1.03 N (J Oral Rehabil 22 (1995) 67-72)", "0.80 to 0.90 N"],
        ["mean force on axial walls of a crown", "1.71 N (PMID 17074189)", "1.62 N"],
        ["mean force on its occlusal surface", "0.45 N (PMID 17074189)", "0.49 N"],
        ["duration of a contact", "0.25 to 0.4 s, or 10 s (J Oral Rehabil 22 (1995) 67-72)", "0.33 to 0.35 s; crown 10 s"],
        ["contacts a second", "1.36 (temporal bone, PMID 34872376)", "1.36; crown 0.10"],
        ["tremor", "8.1 Hz (PMID 11568677), 38 µm rms (Riviere et al.)", "8.1 Hz, 38 µm rms"]]) + "\n" + paragraph(
    """With the crown's occlusal force, the preparation takes 15 minutes. Hand instruments and the condensation of fillings
    have no tremor: with it, the expert gets 88 instead of 96 points in `amalgam-filling`. Implants and sockets of hips are
    drilled with the forces that their exercises cite. Other simulated trainees are displaced plans without forces.""") + "\n"
# Constants that are estimates: name, words in their source, and the experiment that would settle them.
ESTIMATES = [
    ("friction", "friction|all values", "draw the steel or diamond tool over wet tissue with 0.1 to 3 N; measure both forces"),
    ("cutting coefficient, efficiencies", "cutting coefficient|efficienc",
     "press side and end of one bur separately on a block; measure force, torque and rate"),
    ("law of chips", "exponent|grit:|blade:", "mill at a known feed and depth, with three feeds; torque × speed / volume"),
    ("specific energy", "specific energy|all values|as artificial", "mill at a known feed and depth; torque × speed / volume"),
    ("stiffness", "stiffness|all values", "let dentists match the rendered stiffness to specimens under the same tool"),
    ("colour", "colour|all values", "measure the diffuse reflectance of specimens"),
    ("density", "density|all values", "weigh specimens in air and in water"),
    ("thickness of the shell of bone", "thickness", "measure it in CT scans of each class"),
    ("conductivity, heat capacity", "as dentin|between cortical", "measure specimens (hot disk)"),
    ("cooling by the spray", "its reach|root of the flow", "measure a heated block under one handpiece at three flows"),
    ("flow and drops of the spray", "drops|flow:", "collect the water of one handpiece; laser diffraction"),
    ("line of torque", "torque", "brake one named turbine from its free speed to rest in 20 steps"),
    ("run-up", "run-up", "record the speed after a step of the pedal"),
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
        f"""{len(agree)} of the {len(tried)} published results that state their conditions agree with the simulation;
        {len(far)} {'is' if len(far) == 1 else 'are'} off by more than a factor of two. {len(every) - len(tried)} more results cannot be
        simulated, for example because the diameter of a drill is not stated or there is no zirconia.
        `./run bench reality` repeats each experiment with a machine that holds the tool against a slab with the stated
        load or feed. Where a condition is unknown, the simulation runs both ends of its range.
        A row agrees if the band of simulated values meets the accepted range: two standard deviations if the source
        states them, otherwise ±35 % for rates and times, ±20 % for forces and ±2 K for temperatures. Rows with "fit" may set constants, rows
        with "test" may not. `tests/bench/reality/experiments.csv` has all results, and the reasons why some cannot be simulated.
        A source ends with a letter: A table or standard, B abstract, C secondary source, E estimate, F fitted to rows of this
        page. Simulated with: {origin}.""") + "\n"
    for process, some in groups.items():
        known = [row for row in some if row.band]
        if not known:
            continue
        name = process.replace(" ", "_")
        figure(docs / f"reality/{name}.svg", process.capitalize(), known)
        text += f"\n## {process.capitalize()}\n\n"
        text += f"![{process.capitalize()}: simulated over measured, with the accepted range](reality/{name}.svg)\n\n"
        sources = ["", *(f"{row.source} ({row.quality})" for row in known)]
        text += table(["row", "experiment", "measured", "accepted", "simulated", "verdict", "use", "source"],
                      [[f"`{row.id}`", row.what, (row.measured or "–") + (row.text_unit() if row.measured else ""), row.limits(),
                        row.simulated() + row.text_unit(), row.verdict(), row.role, "as above" if source == above else source]
                       for row, source, above in zip(known, sources[1:], sources)])
        because = collections.defaultdict(list)
        for row in known:
            if row.factor() != 1 and row.id in REASONS:
                because[REASONS[row.id]].append(f"`{row.id}`")
        reasons = [f"- {', '.join(some)}: {reason}." for reason, some in because.items()]
        if reasons:
            text += "\nWhy rows differ:\n\n" + "\n".join(paragraph(r).replace("\n", "\n  ") for r in reasons) + "\n"
    return text + HANDS + "\n## Estimates\n\n" + paragraph(
        """Estimates (E) in `assets/materials/`, `assets/motors/` and `assets/tools/`, and of the materials of this page:""") + "\n\n" + table(
        ["constant", "of", "experiment that would settle it"], estimates(HERE.parents[2]))


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
