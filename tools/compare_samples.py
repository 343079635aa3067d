#!/usr/bin/env python3
"""Measures how far bakes of few samples per texel are from 64, and what they cost.

For every material, random pairs of view and light (40 unless told otherwise, theta below 69 degrees) are
baked with 64 samples per texel, and with fewer. The error of a pair is the sum of |difference| over the
sum of radiance. Printed are its median and its 90th percentile over the pairs, and the seconds of the
bakes by the program's own clock. `--before` names an earlier program, whose one sample is
compared with the same 64.

    pip install numpy
    tools/compare_samples.py cobbles leather bark-folder/:0.05 --before earlier/mesotex

A material is a preset, a material file or a folder of maps; `:DEPTH` sets the depth of its relief. Exits 1
when the default's median is more than half of that of one sample.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np

REFERENCE = ["--samples", "64"]
GROUP = 4  # views, and lights, of one bake


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("materials", nargs="+", metavar="MATERIAL")
    parser.add_argument("--program", default="target/release/mesotex")
    parser.add_argument("--before", help="an earlier program")
    parser.add_argument("--size", default="64")
    parser.add_argument("--pairs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", help="as of the program")
    return parser.parse_args()


def random_directions(count, seed):
    """Directions with theta below 69 degrees, even in solid angle, in degrees."""
    random = np.random.default_rng(seed)
    theta = np.degrees(np.arccos(random.uniform(math.cos(math.radians(69.0)), 1.0, count)))
    return np.stack([theta, random.uniform(0.0, 360.0, count)], 1)


def write_directions(path, directions):
    with open(path, "w") as file:
        file.write("theta_deg,phi_deg\n")
        file.writelines(f"{float(theta)!r},{float(phi)!r}\n" for theta, phi in directions)


def bake(args, program, material, extra):
    """The images of pair i (view i, light i), and the reports, added up or averaged."""
    views, lights = random_directions(args.pairs, args.seed), random_directions(args.pairs, args.seed + 1)
    images, reports = [], []
    for first in range(0, args.pairs, GROUP):
        write_directions("views.csv", views[first : first + GROUP])
        write_directions("lights.csv", lights[first : first + GROUP])
        of_group, report = bake_group(args, program, material, extra)
        images += of_group
        reports.append(report)
    mean = lambda key: float(np.mean([report[key] for report in reports]))
    report = {key: mean(key) for key in ("samples", "error_left") if key in reports[0]}
    return np.stack(images).astype(np.float64), {**report, "seconds": len(reports) * mean("seconds")}


def bake_group(args, program, material, extra):
    name, _, depth = material.partition(":")
    source = [name] if os.path.exists(name) else ["--preset", name]
    command = [program, "bake", *source, "-o", "x.sample", "--json", "--size", args.size, "--dtype", "f4"]
    command += ["--views", "views.csv", "--lights", "lights.csv"]
    command += ["--threads", args.threads] if args.threads else []
    command += (["--depth", depth] if depth else []) + extra
    report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    images = np.load("x.sample/radiance.npy", mmap_mode="r")
    return [images[i, i].copy() for i in range(len(images))], report


def main():
    args = arguments()
    for name in ("program", "before"):
        if getattr(args, name):
            setattr(args, name, os.path.abspath(getattr(args, name)))
    materials = []
    for material in args.materials:
        name, colon, depth = material.partition(":")
        materials.append((os.path.abspath(name) if os.path.exists(name) else name) + colon + depth)
    good = True
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        print("material               samples              per texel  median error  90 %    seconds")
        for material in materials:
            off = ["--angular-filter", "off"]
            truth, _ = bake(args, args.program, material, REFERENCE + off)
            medians = {}
            runs = [("before, 1", args.before, ["--samples", "1"])] if args.before else []
            runs += [("1", args.program, ["--samples", "1"] + off), ("default", args.program, off)]
            runs += [(count, args.program, ["--samples", count] + off) for count in ("8", "16")]
            runs += [(f"auto, {e}", args.program, ["--samples", "auto", "--error", e] + off) for e in ("0.05", "0.02")]
            for name, program, extra in runs:
                images, report = bake(args, program, material, extra)
                errors = np.abs(images - truth).sum((1, 2, 3)) / truth.sum((1, 2, 3))
                medians[name] = float(np.median(errors))
                said = f"  (says {report['error_left']:.4f})" if "error_left" in report else ""
                print(
                    f"{os.path.basename(material):22} {name:20} {report.get('samples', 1.0):9.2f}  {medians[name]:12.4f}"
                    f"  {np.quantile(errors, 0.9):.4f}  {report['seconds']:7.2f}{said}",
                    flush=True,
                )
            good &= medians["default"] <= 0.5 * medians.get("before, 1", medians["1"])
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
