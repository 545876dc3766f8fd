#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""chart_table.py RESULTS.csv...: the table "Charts" of docs/benchmarks.md, in Markdown.

Of the rows that gxybench wrote: one backend, one rank, scenes of volumes. A scene's method in a later file takes the place of the same in
an earlier one, such as when a noisy one was run again. For each scene: the ratio of processor times of `adaptive` and `fixed` at equal
error, least and most over the errors of their settings that both reach, between settings in logarithms, those left out that another beats
in time and error; the least RMS error of each method's ladder; and what the default tolerance takes.
"""
import argparse
import csv
import math

DEFAULT = 1 / 512


def front(rows, error):
    """[(time, error)] of the settings that no other beats."""
    best = []
    for time, e in sorted((float(r["cpu_s"]), float(r[error])) for r in rows):
        if e > 0 and (not best or e < best[-1][1]):
            best.append((time, e))
    return best


def time_for(curve, error):
    for (t0, e0), (t1, e1) in zip(curve, curve[1:]):
        if e1 <= error <= e0:
            return t0 * (t1 / t0) ** (math.log(error / e0) / math.log(e1 / e0))
    raise ValueError("beyond the curve")


def ratios(ours, theirs):
    least, most = max(c[-1][1] for c in (ours, theirs)), min(c[0][1] for c in (ours, theirs))
    errors = [e for _, e in ours + theirs if least <= e <= most]
    return sorted(time_for(ours, e) / time_for(theirs, e) for e in errors)


def span(found):
    return f"{found[0]:.2f} to {found[-1]:.2f}" if found else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="+")
    curves = {}  # of scene and method
    for path in parser.parse_args().results:
        with open(path, newline="") as file:
            read = {}
            for row in csv.DictReader(file):
                read.setdefault((row["scene"], row["method"]), []).append(row)
            curves.update(read)
    print("| scene | adaptive / fixed, RMS error | largest error | reach: adaptive | fixed | uncorrected | RMS | largest error | CPU s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for scene, method in sorted(curves):
        if method != "adaptive" or (scene, "fixed") not in curves:
            continue
        rows = curves[scene, method]
        reach = [min((float(r["rms_error"]) for r in curves.get((scene, m), [])), default=math.nan) for m in ("adaptive", "fixed", "uncorrected")]
        default = next(r for r in rows if math.isclose(float(r["tolerance"]), DEFAULT))
        by = [ratios(front(rows, e), front(curves[scene, "fixed"], e)) for e in ("rms_error", "max_error")]
        print(f"| {scene} | {span(by[0])} | {span(by[1])} | " + " | ".join("" if math.isnan(r) else f"{r:.1e}" for r in reach) +
              f" | {float(default['rms_error']):.1e} | {float(default['max_error']):.1e} | {float(default['cpu_s']):.2f} |")


if __name__ == "__main__":
    main()
