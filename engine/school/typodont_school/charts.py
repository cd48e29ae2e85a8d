"""Charts as SVG, and the statistics behind them."""
import math
from collections import Counter
from statistics import NormalDist, fmean, stdev
from xml.sax.saxutils import escape

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 640, 260, 44, 14, 14, 40


def student_t(p, freedom):
    """Quantile of Student's t: Abramowitz & Stegun 26.7.5; within 1 % from 3 degrees of freedom."""
    z = NormalDist().inv_cdf(p)
    return (z + (z**3 + z) / (4 * freedom) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
            + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * freedom**3))


MIN_VALUES = 4  # of an interval; below, a mean would tell a student the points of others


def mean_interval(values):
    """Returns mean, lower and upper end of its 95 % interval; no interval below four values."""
    mean = fmean(values)
    if len(values) < MIN_VALUES:
        return mean, None, None
    half = student_t(0.975, len(values) - 1) * stdev(values) / math.sqrt(len(values))
    return mean, max(0, mean - half), min(100, mean + half)


class Plot:
    """Axes from the data's range to the picture."""
    def __init__(self, title, x_range, y_range, x_label, y_label):
        self.x0, self.x1 = x_range if x_range[1] > x_range[0] else (x_range[0] - 0.5, x_range[0] + 0.5)
        self.y0, self.y1 = y_range if y_range[1] > y_range[0] else (y_range[0], y_range[0] + 1)
        self.parts = [f'<svg class="chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(title, {chr(34): "&quot;"})}">']
        self.label((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 6, x_label, "axis", "middle")
        self.label(LEFT, TOP - 3, y_label, "axis", "start")

    def x(self, value):
        return LEFT + (value - self.x0) / (self.x1 - self.x0) * (WIDTH - LEFT - RIGHT)

    def y(self, value):
        return HEIGHT - BOTTOM - (value - self.y0) / (self.y1 - self.y0) * (HEIGHT - BOTTOM - TOP)

    def label(self, x, y, text, kind, anchor):
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" class="{kind}" text-anchor="{anchor}">{escape(text)}</text>')

    def grid(self, x_ticks, y_ticks):
        for tick in y_ticks:
            self.parts.append(f'<path class="grid" d="M{LEFT} {self.y(tick):.1f}H{WIDTH - RIGHT}"/>')
            self.label(LEFT - 6, self.y(tick) + 4, f"{tick:g}", "tick", "end")
        for tick in x_ticks:
            self.label(self.x(tick), HEIGHT - BOTTOM + 16, f"{tick:g}", "tick", "middle")

    def line(self, points, kind):
        if points:
            self.parts.append(f'<polyline class="{kind}" points="{" ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in points)}"/>')

    def band(self, rows):
        if rows:
            edge = [(x, low) for x, low, _ in rows] + [(x, high) for x, _, high in reversed(rows)]
            self.parts.append(f'<polygon class="band" points="{" ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in edge)}"/>')

    def dots(self, points):
        for x, y, text in points:
            self.parts.append(f'<circle class="dot" cx="{self.x(x):.1f}" cy="{self.y(y):.1f}" r="4"><title>{escape(text)}</title></circle>')

    def bars(self, edges, counts):
        for low, high, count in zip(edges, edges[1:], counts):
            top = self.y(count)
            self.parts.append(f'<rect class="bar" x="{self.x(low) + 1:.1f}" y="{top:.1f}" width="{self.x(high) - self.x(low) - 2:.1f}" '
                              f'height="{self.y(0) - top:.1f}"><title>{low:g}–{high:g}: {count}</title></rect>')

    def mark(self, x, text):
        self.parts.append(f'<path class="mark" d="M{self.x(x):.1f} {TOP}V{HEIGHT - BOTTOM}"/>')
        self.label(self.x(x) + 4, TOP + 10, text, "tick", "start")

    def done(self):
        return "".join(self.parts) + "</svg>"


def round_step(span, count=5):
    raw = span / count if span > 0 else 1
    power = 10 ** math.floor(math.log10(raw))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= raw)


def ticks(low, high, count=5):
    step = round_step(high - low, count)
    first = math.ceil(low / step - 1e-9)
    return [round(i * step, 10) for i in range(first, math.floor(high / step + 1e-9) + 1)]


def learning_curve(title, rows, own, x_label, y_label):
    """rows: (attempt, mean, low, high) of a group; own: (attempt, points, text) of one student."""
    last = max([row[0] for row in rows] + [row[0] for row in own] + [2])
    plot = Plot(title, (0.5, last + 0.5), (0, 100), x_label, y_label)
    plot.grid([t for t in ticks(1, last, 8) if t == int(t) and t >= 1], (0, 25, 50, 75, 100))
    plot.band([(row[0], row[2], row[3]) for row in rows if row[2] is not None])
    plot.line([row[:2] for row in rows], "mean")
    plot.line([row[:2] for row in own], "own")
    plot.dots(own)
    return plot.done()


def histogram(title, values, x_label, y_label, target=None, target_label=""):
    if not values:
        return ""
    low, high = min(values), max(values)
    step = round_step(high - low, 14)
    first = math.floor(low / step)
    count = max(1, math.floor(high / step) - first + 1)
    bins = Counter(math.floor(value / step) for value in values)
    counts = [bins[first + i] for i in range(count)]
    edges = [round((first + i) * step, 10) for i in range(count + 1)]
    plot = Plot(title, (edges[0], edges[-1]), (0, max(counts)), x_label, y_label)
    plot.grid(ticks(edges[0], edges[-1], 8), [t for t in ticks(0, max(counts), 4) if t == int(t)])
    plot.bars(edges, counts)
    if target is not None and edges[0] <= target <= edges[-1]:
        plot.mark(target, target_label)
    return plot.done()


def spark(values):
    """A small curve for a table's row."""
    if len(values) < 2:
        return ""
    points = " ".join(f"{2 + 96 * i / (len(values) - 1):.1f},{22 - 0.2 * max(0, min(100, v)):.1f}" for i, v in enumerate(values))
    return f'<svg class="spark" viewBox="0 0 100 24" aria-hidden="true"><polyline class="own" points="{points}"/></svg>'
