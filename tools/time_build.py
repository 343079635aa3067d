#!/usr/bin/env python3
"""Times clean release builds of commits of this repository, alternating between them, and what the compiler spent on which crate.

Needs: Python's standard library, git, cargo with the crates at hand, 2 GB of disk, a machine with nothing else to do.
Run:   tools/time_build.py HEAD~10 HEAD --runs 3
Prints the wall and processor seconds of every build, their medians and ratio, and the slowest crates of each commit's last build.
"""

import argparse
import json
import pathlib
import re
import resource
import shutil
import statistics
import subprocess
import tempfile
import time


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commits", nargs="+")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--slowest", type=int, default=8, help="how many crates to list")
    return parser.parse_args()


def check_out(commit, folder):
    subprocess.run(["git", "clone", "--quiet", "--shared", "--no-checkout", repository(), folder], check=True)
    subprocess.run(["git", "checkout", "--quiet", "--detach", commit], cwd=folder, check=True)
    subprocess.run(["cargo", "fetch", "--quiet", "--locked"], cwd=folder, check=True)


def repository():
    found = subprocess.run(["git", "rev-parse", "--show-toplevel"], check=True, capture_output=True, text=True)
    return found.stdout.strip()


def hash_of(commit):
    found = subprocess.run(["git", "rev-parse", commit], check=True, capture_output=True, text=True)
    return found.stdout.strip()


def build(folder):
    """Wall and processor seconds of one clean build."""
    shutil.rmtree(folder / "target", ignore_errors=True)
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    command = ["cargo", "build", "--release", "--locked", "--quiet", "--timings", "--target-dir", "target"]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    wall, after = time.monotonic() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def slowest_crates(folder, count):
    """Seconds and names, from the page that `cargo --timings` writes."""
    pages = sorted((folder / "target/cargo-timings").glob("cargo-timing-*.html"))
    units = json.loads(re.search(r"UNIT_DATA = (\[.*?\]);\n", pages[-1].read_text(), re.S).group(1))
    return sorted(((unit["duration"], unit["name"]) for unit in units), reverse=True)[:count]


def main():
    options = arguments()
    with tempfile.TemporaryDirectory() as scratch:
        folders = {commit: pathlib.Path(scratch) / str(at) for at, commit in enumerate(options.commits)}
        for commit, folder in folders.items():
            check_out(hash_of(commit), folder)
        times = {commit: [] for commit in options.commits}
        for _ in range(options.runs):
            for commit, folder in folders.items():
                times[commit].append(build(folder))
                wall, processor = times[commit][-1]
                print(f"{commit}: {wall:.0f} s, {processor:.0f} s of processor time", flush=True)
        first = statistics.median(wall for wall, _ in times[options.commits[0]])
        for commit, folder in folders.items():
            wall, processor = (statistics.median(column) for column in zip(*times[commit]))
            print(f"{commit}: median {wall:.0f} s ({wall / first:.2f} of the first), {processor:.0f} s of processor time")
            crates = slowest_crates(folder, options.slowest)
            print("    " + ", ".join(f"{name} {seconds:.0f}" for seconds, name in crates))


if __name__ == "__main__":
    main()
