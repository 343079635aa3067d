#!/usr/bin/env python3
"""Compares the plan of a scene with what its stages took.

    tools/compare_plan.py MESOTEX SCENE.toml [--threads N] [--quality draft|final]

Runs every stage of the scene (`run --fresh`) and prints, per stage, planned and taken seconds and their ratio. Exit code 1
where a stage of half a second or more is off by more than a factor of 2. Surfaces that an earlier run prepared are read
again, which makes `synth` shorter than planned: give it a scene that was not run before. Standard library only.
"""

import argparse
import json
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

# Shorter stages are over before the clock says much.
SHORTEST = 0.5


def report(mesotex, scene, options):
    """What `mesotex run` reports as JSON."""
    command = [mesotex, "run", scene, "--json", "--fresh", *options]
    run = subprocess.run(command, check=True, stdout=subprocess.PIPE)
    return json.loads(run.stdout)


def seconds_taken(scene):
    """Seconds by the words of each stage's command line, as the record of the run has them."""
    folder = tomllib.loads(Path(scene).read_text()).get("output", ".")
    record = json.loads((Path(scene).parent / folder / "run.json").read_text())
    # A key is `VERSION --seed N WORDS`.
    return {key.split(" ", 3)[3]: stage["seconds"] for key, stage in record["stages"].items()}


def words_of(stage):
    """The words of a stage's command line: `mesotex WORDS --seed N` without program and seed, unquoted."""
    return " ".join(shlex.split(stage["command"])[1:-2])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesotex", help="the program, a release build")
    parser.add_argument("scene", help="the scene; its outputs are made anew")
    parser.add_argument("--threads", default="2")
    parser.add_argument("--quality", default="final", choices=["draft", "final"])
    options = parser.parse_args()
    shared = ["--threads", options.threads, "--quality", options.quality]
    plan = report(options.mesotex, options.scene, [*shared, "--plan"])["plan"]["stages"]
    commands = report(options.mesotex, options.scene, [*shared, "--dry-run"])["stages"]
    report(options.mesotex, options.scene, shared)
    taken = seconds_taken(options.scene)
    is_off = False
    print(f"{'stage':24} {'planned':>9} {'taken':>9} {'ratio':>6}")
    for planned, stage in zip(plan, commands):
        seconds, expected = taken.get(words_of(stage)), planned["seconds"]
        if expected is None or seconds is None:
            continue
        ratio = expected / max(seconds, 1e-3)
        counts = max(seconds, expected) >= SHORTEST
        is_off |= counts and not 0.5 <= ratio <= 2.0
        note = "" if counts else "  (short)"
        print(f"{stage['stage']:24} {expected:8.2f}s {seconds:8.2f}s {ratio:6.2f}{note}")
    sys.exit(1 if is_off else 0)


if __name__ == "__main__":
    main()
