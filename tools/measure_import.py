#!/usr/bin/env python3
"""Imports an image set and measures time and memory.

Needs: Python's standard library, a release build, Linux or macOS.
Run:   tools/make_ubo2003_archive.py -o weave.zip
       tools/measure_import.py weave.zip --mesotex target/release/mesotex --runs 3

Printed are seconds and peak memory of each run, and the images per second of the fastest. Exit code 1 if
--most-seconds or --most-mib is exceeded by every run.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source")
    parser.add_argument("--mesotex", default="target/release/mesotex")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--work", default=None, help="where the sample is written and removed; default: a new folder")
    parser.add_argument("--most-seconds", type=float, default=120)
    parser.add_argument("--most-mib", type=float, default=1024)
    return parser.parse_args()


def run(arguments, target):
    """Seconds, peak MiB and the report of one import."""
    command = [arguments.mesotex, "import", arguments.source, "-o", target, "--json", "--quiet"]
    command += ["--threads", str(arguments.threads)]
    begun = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
    report = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - begun
    if status != 0:
        sys.exit(f"{' '.join(command)}: failed")
    unit = 1 if sys.platform == "darwin" else 1024
    return seconds, usage.ru_maxrss * unit / 2**20, json.loads(report)


def main():
    arguments = parse()
    work = tempfile.mkdtemp(dir=arguments.work)
    try:
        runs = [run(arguments, os.path.join(work, "x.sample")) for _ in range(arguments.runs)]
    finally:
        shutil.rmtree(work)
    for seconds, mib, report in runs:
        print(f"{seconds:.1f} s, {mib:.0f} MiB, {report['images']} images")
    seconds, mib, report = min(runs, key=lambda run: run[0])
    print(f"fastest: {report['images'] / seconds:.0f} images per second on {arguments.threads} threads")
    sys.exit(seconds > arguments.most_seconds or mib > arguments.most_mib)


if __name__ == "__main__":
    main()
