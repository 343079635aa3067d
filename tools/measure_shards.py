#!/usr/bin/env python3
"""Measures a texton analysis in shards: seconds and memory of every shard and of the reduction, and whether the
result has the same bytes as one run.

Needs: nothing beside Python 3 on Linux.
Run:   tools/measure_shards.py large.sample --shards 4 --options "--memory 3GiB" --limit 1GiB

The memory of a process is what belongs to it alone: its anonymous pages (Anonymous and Swap of
/proc/PID/smaps_rollup), looked at every 50 ms. Pages of the sample's file are the system's, which takes them back at
will; VmHWM counts those that are mapped, and is printed beside. With --limit, a shard that takes more fails. Where the
group of this process may be divided, each process also runs in a control group of its own with that limit
(memory.max, pages of files included). Parts and results are written to --folder and deleted.
"""

import argparse
import filecmp
import os
import shlex
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass

UNITS = {"KiB": 1 << 10, "MiB": 1 << 20, "GiB": 1 << 30}
GROUPS = "/sys/fs/cgroup"
PERIOD = 0.05


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sample")
    parser.add_argument("--program", default="mesotex")
    parser.add_argument("--shards", type=int, default=4)
    parser.add_argument("--options", default="", help="options of textons, for the shards and the one run alike")
    parser.add_argument("--limit", help="memory of a shard, as 1GiB")
    parser.add_argument("--folder", help="where parts are written; default: a temporary folder")
    parser.add_argument("--no-whole", action="store_true", help="do not compare with one run")
    return parser.parse_args()


def bytes_of(text):
    for unit, factor in UNITS.items():
        if text.endswith(unit):
            return int(float(text[: -len(unit)]) * factor)
    return int(text)


def fields(path, names):
    """Sum of lines `NAME: N kB`, in bytes."""
    total = 0
    with open(path) as file:
        for line in file:
            name, _, rest = line.partition(":")
            if name in names:
                total += int(rest.split()[0]) * 1024
    return total


@dataclass
class Measured:
    """What a process took: seconds, bytes of its own, VmHWM, and bytes that came from the disk."""

    seconds: float
    own: int
    peak: int
    read: int


def new_group(limit):
    """A control group with a memory limit, or None where none can be made."""
    for folder, name in (("memory", "memory.limit_in_bytes"), ("", "memory.max")):
        path = os.path.join(GROUPS, folder, f"measure.{os.getpid()}")
        try:
            os.mkdir(path)
        except OSError:
            continue
        # Only in a tree of control groups does a new folder have files.
        if os.path.exists(os.path.join(path, name)):
            with open(os.path.join(path, name), "w") as file:
                file.write(str(limit))
            return path
        os.rmdir(path)
    return None


def run(words, group=None, environment=None):
    """Runs a command and measures it."""
    began = time.monotonic()
    enter = None
    if group:
        def enter():
            with open(os.path.join(group, "cgroup.procs"), "w") as file:
                file.write(str(os.getpid()))
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, preexec_fn=enter, env=environment)
    own = peak = 0
    while True:
        ended, status, usage = os.wait4(process.pid, os.WNOHANG)
        if ended:
            process.returncode = os.waitstatus_to_exitcode(status)
            break
        try:
            own = max(own, fields(f"/proc/{process.pid}/smaps_rollup", {"Anonymous", "Swap"}))
            peak = max(peak, fields(f"/proc/{process.pid}/status", {"VmHWM"}))
        except (OSError, ProcessLookupError):
            pass
        time.sleep(PERIOD)
    if process.returncode:
        raise SystemExit(f"{shlex.join(words)} ended with {process.returncode}")
    return Measured(time.monotonic() - began, own, peak, usage.ru_inblock * 512)


def say(what, result, more=""):
    own, peak = result.own / 2**20, result.peak / 2**20
    print(f"{what:12} {result.seconds:8.1f} s  own {own:7.0f} MiB  VmHWM {peak:7.0f} MiB{more}", flush=True)


def measure(arguments, folder):
    options = shlex.split(arguments.options)
    base = [arguments.program, "textons", arguments.sample]
    limit = bytes_of(arguments.limit) if arguments.limit else None
    group = new_group(limit) if limit else None
    if limit:
        print("limit:", "a control group per shard" if group else "own memory is compared; no control group can be made")
    parts = []
    for shard in range(arguments.shards):
        part = os.path.join(folder, f"part{shard}.npz")
        words = base + options + ["--shard", f"{shard}/{arguments.shards}", "-o", part, "--quiet"]
        result = run(words, group)
        say(f"shard {shard}", result, f"  part {os.path.getsize(part) / 2**20:.0f} MiB")
        if limit and result.own > limit:
            raise SystemExit(f"shard {shard} took more than {arguments.limit}")
        parts.append(part)
    if group:
        os.rmdir(group)
    joined = os.path.join(folder, "joined.textons.npz")
    say("reduction", run(base + ["--reduce"] + parts + ["-o", joined, "--quiet"]))
    if arguments.no_whole:
        return
    whole = os.path.join(folder, "whole.textons.npz")
    say("one run", run(base + options + ["-o", whole, "--quiet"]))
    same = filecmp.cmp(joined, whole, shallow=False)
    print("the same bytes" if same else "OTHER BYTES")
    if not same:
        raise SystemExit(1)


def main():
    arguments = parse()
    folder = arguments.folder or tempfile.mkdtemp(prefix="shards-")
    os.makedirs(folder, exist_ok=True)
    try:
        measure(arguments, folder)
    finally:
        if not arguments.folder:
            shutil.rmtree(folder)


if __name__ == "__main__":
    main()
