#!/usr/bin/env python3
"""Times two builds of mesotex against each other, command by command, in pairs of one run.

Needs: Python's standard library, two release builds, some GB of disk.
Run:   tools/compare_builds.py --before old/mesotex --after target/release/mesotex --mesh bunny.obj
Prints, per command, the median of both and the ratio, and every time. Inputs are made once, by the first build.
"""

import argparse
import os
import shutil
import statistics
import subprocess
import tempfile
import time


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", required=True)
    parser.add_argument("--after", required=True)
    parser.add_argument("--mesh", required=True)
    parser.add_argument("--vertices", default="250000")
    parser.add_argument("--runs", type=int, default=3)
    return parser.parse_args()


def run(mesotex, words):
    begun = time.monotonic()
    subprocess.run([mesotex, *words, "-q"], check=True)
    return time.monotonic() - begun


BAKE = ["bake", "--preset", "weave", "--size", "64", "--views", "12x5", "--lights", "12x5", "--samples", "1"]


def make_inputs(options):
    for words in [
        [*BAKE, "-o", "w.sample"],
        ["textons", "w.sample", "-o", "w.textons.npz"],
        ["gram", "w.textons.npz", "-o", "w.space.npz"],
        ["knn", "w.space.npz", "-o", "w.knn.npz"],
        ["mesh", options.mesh, "-o", "k.ply", "--vertices", options.vertices],
        ["synth", "w.space.npz", "w.knn.npz", "k.ply", "-o", "k.map.ply"],
    ]:
        run(options.before, words)


def commands(options):
    """In order: the second synthesis finds the surface that the first one prepared."""
    synth = ["synth", "w.space.npz", "w.knn.npz", "out/k.ply", "-o", "out/k.map.ply"]
    return {
        "bake": [*BAKE, "-o", "out/w.sample"],
        "textons": ["textons", "w.sample", "-o", "out/t.npz"],
        "gram": ["gram", "w.textons.npz", "-o", "out/s.npz"],
        "knn": ["knn", "w.space.npz", "-o", "out/n.npz"],
        "mesh": ["mesh", "k.ply", "-o", "out/m.ply", "--vertices", options.vertices],
        "synth, prepared": synth,
        "synth, cached": synth,
        "render": ["render", "w.sample", "k.map.ply", "-o", "out/f", "--sweep", "light-azimuth", "--frames", "6",
                   "--size", "1280x960"],
        "info": ["info", "w.sample"],
    }


def main():
    options = arguments()
    for name in ["before", "after", "mesh"]:
        setattr(options, name, os.path.abspath(getattr(options, name)))
    times = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        make_inputs(options)
        for _ in range(options.runs):
            for build in ["before", "after"]:
                shutil.rmtree("out", ignore_errors=True)
                os.mkdir("out")
                shutil.copy("k.ply", "out/k.ply")
                for name, words in commands(options).items():
                    times.setdefault((name, build), []).append(run(getattr(options, build), words))
        os.chdir("/")
    for name in commands(options):
        before, after = times[name, "before"], times[name, "after"]
        medians = statistics.median(before), statistics.median(after)
        every = " ".join(f"{b:.2f}/{a:.2f}" for b, a in zip(before, after))
        print(f"{name:16} {medians[0]:7.2f} {medians[1]:7.2f} {medians[1] / medians[0]:6.2f}   {every}")


if __name__ == "__main__":
    main()
