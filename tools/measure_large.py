#!/usr/bin/env python3
"""Measures what commands take of memory and time that work with a sample larger than the memory they may take.

Needs: nothing beside Python 3 on Linux, where control groups can be made (root).
Run:   tools/measure_large.py large.sample --memory 1GiB --folder work

Every command runs twice, with the same options: alone, and in a control group that may take as much memory as the
command is told to work in (textons --memory, --table-memory of what shades) and --spare beside, pages of files
included. A group that takes more is ended by the system. Printed are what belongs to the process alone, VmHWM, bytes
from the disk, and the seconds of the run in the group over those of the run alone; last, whether both wrote the same
bytes. The sample's pages are forgotten before every run.

The surface is a torus of 20,000 vertices. `bake` is measured by --bake, which makes the sample in a group.
"""

import argparse
import filecmp
import math
import os
import shlex

from measure_readahead import forget
from measure_shards import bytes_of, new_group, run

MIB = 1 << 20
RINGS, SIDES = 200, 100


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sample")
    parser.add_argument("--program", default="mesotex")
    parser.add_argument("--memory", default="1GiB", help="what commands are told to work in")
    parser.add_argument("--spare", default="256MiB", help="what a group may take beside")
    parser.add_argument("--folder", required=True, help="where products are written; kept")
    parser.add_argument("--only", nargs="+", help="commands to measure, as they are called in the table")
    parser.add_argument("--bake", help="options of the bake that makes the sample")
    parser.add_argument("--threads", type=int, default=1)
    return parser.parse_args()


def write_torus(path):
    with open(path, "w", encoding="utf-8") as file:
        for ring in range(RINGS):
            for side in range(SIDES):
                u, v = 2 * math.pi * ring / RINGS, 2 * math.pi * side / SIDES
                r = 1 + 0.4 * math.cos(v)
                file.write(f"v {r * math.cos(u):.6f} {0.4 * math.sin(v):.6f} {r * math.sin(u):.6f}\n")
        for ring in range(RINGS):
            for side in range(SIDES):
                corners = ((0, 0), (0, 1), (1, 1), (1, 0))
                numbers = [(ring + i) % RINGS * SIDES + (side + j) % SIDES + 1 for i, j in corners]
                file.write("f {} {} {} {}\n".format(*numbers))


def commands(sample, memory):
    """The commands: name, options, inputs, what it writes, whether it is told its memory; {} is the folder of a run."""
    table = f"--table-memory={memory // MIB // 2}"
    frames = "--size 640x480 --sweep light-azimuth --frames 4 --animation none"
    return {
        "textons": f"textons {sample} -o {{}}/a.textons.npz --memory {memory // MIB}MiB",
        "gram": "gram {}/a.textons.npz -o {}/a.space.npz",
        "knn": "knn {}/a.space.npz -o {}/a.knn.npz",
        "synth": "synth {}/a.space.npz {}/a.knn.npz {}/torus.obj -o {}/a.map.ply",
        "render by vertex": f"render {sample} {{}}/a.map.ply -o {{}}/vertex {frames} {table}",
        "render by pixel": f"render {sample} {{}}/a.map.ply -o {{}}/pixel {frames} {table} --shading pixel",
        "bake-maps": f"bake-maps {sample} {{}}/a.map.ply -o {{}}/maps --unwrap --resolution 512 {table}",
        "export ptm": f"export {sample} --to ptm -o {{}}/a.ptm",
        "info": f"info {sample}",
    }


def say(name, alone, limited, limit):
    columns = [
        name,
        f"{limit / MIB:.0f}",
        f"{limited.own / MIB:.0f}",
        f"{limited.peak / MIB:.0f}",
        f"{limited.read / 1e9:.1f}",
        f"{limited.seconds:.1f}",
    ]
    if alone:
        columns += [f"{alone.own / MIB:.0f}", f"{alone.read / 1e9:.1f}", f"{limited.seconds / alone.seconds:.2f}"]
    print(" | ".join(columns), flush=True)


def differing(first, second):
    """Paths of files below two folders that are not the same in both."""
    def files(folder):
        found = set()
        for at, folders, names in os.walk(folder):
            folders[:] = [name for name in folders if not name.endswith("cache")]
            found |= {os.path.relpath(os.path.join(at, name), folder) for name in names}
        return found
    both = files(first) | files(second)
    paths = [[os.path.join(folder, path) for folder in (first, second)] for path in sorted(both)]
    return [pair[0] for pair in paths if not all(map(os.path.exists, pair)) or not filecmp.cmp(*pair, shallow=False)]


def main():
    arguments = parse()
    memory, spare = bytes_of(arguments.memory), bytes_of(arguments.spare)
    sample = os.path.abspath(arguments.sample)
    ends = ["--threads", str(arguments.threads), "--quiet"]
    folders = [os.path.join(os.path.abspath(arguments.folder), name) for name in ("alone", "limited")]
    for folder in folders:
        os.makedirs(folder, exist_ok=True)
        write_torus(os.path.join(folder, "torus.obj"))
    group = new_group(memory + spare)
    if not group:
        raise SystemExit("no control group can be made here")
    print("command | group, MiB | own, MiB | VmHWM, MiB | read, GB | s | own alone, MiB | read alone, GB | s over s alone")
    try:
        if arguments.bake:
            words = [arguments.program, "bake", "-o", sample] + shlex.split(arguments.bake) + ends
            say("bake", None, run(words, group), memory + spare)
        for name, line in commands(sample, memory).items():
            if arguments.only and name not in arguments.only:
                continue
            found = []
            for folder, of_run in zip(folders, (None, group)):
                words = [arguments.program] + line.replace("{}", folder).split() + ends
                forget(sample)
                found.append(run(words, of_run))
            say(name, *found, memory + spare)
    finally:
        os.rmdir(group)
    others = differing(*folders)
    print("OTHER BYTES: " + ", ".join(others) if others else "the same bytes")


if __name__ == "__main__":
    main()
