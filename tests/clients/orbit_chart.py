# SPDX-License-Identifier: Apache-2.0
"""The chart of orbit_benchmark.py: frames a second over ranks, a panel for each scene, a curve for each number in flight."""
import math

# Colours that the colour-blind can tell apart, too (Okabe and Ito). The paper behind them is white in any theme.
COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00"]
WIDTH, HEIGHT, LEFT, TOP, BOTTOM, GAP = 300, 230, 46, 72, 46, 20


def text(x, y, words, anchor="middle", size=12, more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" {more}>{words}</text>'


class Axis:
    """Logarithmic: from the pixel `begin`, where `low` is, to the pixel `end`, where `high` is."""

    def __init__(self, low, high, begin, end):
        self.low, self.high, self._begin, self._end = low, high, begin, end

    def at(self, value):
        part = math.log(value / self.low) / math.log(self.high / self.low) if self.high > self.low else 0.5
        return self._begin + part * (self._end - self._begin)


def ticks(low, high):
    """1, 2 and 5 times powers of ten from `low` to `high`."""
    found = []
    for decade in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1):
        found += [n * 10 ** decade for n in (1, 2, 5)]
    return [n for n in found if low <= n <= high]


def panel(rows, ranks, left, colors):
    low, high = min(r["frames/s"] for r in rows), max(r["frames/s"] for r in rows)
    x = Axis(ranks[0], ranks[-1], left + LEFT + 8, left + WIDTH - 8)
    y = Axis(low / 1.3, high * 1.3, TOP + HEIGHT, TOP)
    out = [text((left + LEFT + left + WIDTH) / 2, TOP - 8, rows[0]["scene"], size=13),
           f'<rect x="{left + LEFT}" y="{TOP}" width="{WIDTH - LEFT}" height="{HEIGHT}" fill="none" stroke="#888"/>']
    for n in ticks(y.low, y.high):
        out += [f'<path d="M{left + LEFT} {y.at(n):.1f}H{left + WIDTH}" stroke="#ddd"/>',
                text(left + LEFT - 5, y.at(n) + 4, f"{n:g}", "end")]
    out += [text(x.at(n), TOP + HEIGHT + 17, n) for n in ranks]
    for in_flight, color in colors.items():
        points = sorted((r["ranks"], r["frames/s"]) for r in rows if r["in flight"] == in_flight)
        places = [(x.at(n), y.at(rate)) for n, rate in points]
        line = " ".join(f"{a:.1f},{b:.1f}" for a, b in places)
        out.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="1.8"/>')
        out += [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3.5" fill="{color}"/>' for a, b in places]
    return out


def chart(rows, what):
    """An SVG document of rows that have "scene", "ranks", "in flight" and "frames/s"; `what`: a line below the title."""
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    ranks = sorted({r["ranks"] for r in rows})
    numbers = sorted({r["in flight"] for r in rows})
    colors = {n: COLORS[i % len(COLORS)] for i, n in enumerate(numbers)}
    width, height = len(scenes) * (WIDTH + GAP) + GAP, TOP + HEIGHT + BOTTOM
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
           'font-family="sans-serif" fill="#222">', f'<rect width="{width}" height="{height}" fill="#fff"/>',
           text(GAP, 20, "Frames per second of a camera orbit", "start", 14), text(GAP, 37, what, "start")]
    for i, n in enumerate(numbers):
        left = width - GAP - 90 * (len(numbers) - i)
        out += [f'<path d="M{left} 16h18" stroke="{colors[n]}" stroke-width="1.8"/>',
                f'<circle cx="{left + 9}" cy="16" r="3.5" fill="{colors[n]}"/>', text(left + 23, 20, f"{n} in flight", "start")]
    for i, scene in enumerate(scenes):
        out += panel([r for r in rows if r["scene"] == scene], ranks, GAP + i * (WIDTH + GAP), colors)
    out.append(text(width / 2, height - 9, "ranks"))
    return "\n".join(out + ["</svg>"]) + "\n"
