#!/usr/bin/env python3
"""Sends a signal at many moments of big runs and measures how long each takes to exit.

Needs: Python's standard library, a release build, some GB of disk, half an hour.
Run:   tools/measure_interruptions.py --mesotex target/release/mesotex --work /tmp/interruptions
       tools/measure_interruptions.py --stages knn,render --moments 20

Inputs are made once in the work folder. Each stage runs once to the end (or --longest seconds), then
once per moment. Printed are the worst latency, the moment it was met at, and how many runs the
watching thread had to end (those that took longer than its grace period of 1 s).
Exit code 1 if a latency reached 2 s, an exit code was wrong, or no hint was printed.
"""

import argparse
import math
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import time
import zlib

GRACE = 1.0
LIMIT = 2.0


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesotex", default="target/release/mesotex")
    parser.add_argument("--work", default="/tmp/mesotex-interruptions")
    parser.add_argument("--moments", type=int, default=10)
    parser.add_argument("--longest", type=float, default=40.0, help="seconds of a run that are tried")
    parser.add_argument("--signal", choices=["TERM", "INT", "HUP"], default="TERM")
    parser.add_argument("--stages", default="", help="names, or beginnings of names; default: all")
    return parser.parse_args()


def png(path, width, height, seed):
    """An RGB picture with some noise."""
    noise = random.Random(seed)
    tile = [bytes([0]) + noise.randbytes(3 * width) for _ in range(16)]
    rows = zlib.compress(b"".join(tile[row % 16] for row in range(height)), 1)

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))


def torus(path, columns, rows):
    """A bumpy torus as binary PLY."""
    with open(path, "wb") as file:
        count = columns * rows
        file.write(
            f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {2 * count}\nproperty list uchar int vertex_indices\nend_header\n".encode()
        )
        for i in range(columns):
            u = 2 * math.pi * i / columns
            body = bytearray()
            for j in range(rows):
                v = 2 * math.pi * j / rows
                r = 0.4 + 0.03 * math.sin(9 * u) * math.cos(7 * v)
                x = 1 + r * math.cos(v)
                body += struct.pack("<3f", x * math.cos(u), r * math.sin(v), x * math.sin(u))
            file.write(body)
        for i in range(columns):
            body = bytearray()
            for j in range(rows):
                a, b = i * rows + j, i * rows + (j + 1) % rows
                c, d = (i + 1) % columns * rows + j, (i + 1) % columns * rows + (j + 1) % rows
                body += struct.pack("<B3iB3i", 3, a, b, d, 3, a, d, c)
            file.write(body)


def polygon(path, corners):
    """One face: a star with uneven spikes."""
    noise = random.Random(1)
    with open(path, "w") as file:
        for k in range(corners):
            angle, radius = 2 * math.pi * k / corners, noise.uniform(0.2, 1)
            file.write(f"v {radius * math.cos(angle):.9f} {radius * math.sin(angle):.9f} 0\n")
        file.write("f " + " ".join(str(k + 1) for k in range(corners)) + "\n")


class Inputs:
    """Files that are made when a stage first asks for them."""

    def __init__(self, mesotex, work):
        self.mesotex, self.work = mesotex, work

    def make(self, name, build):
        path = os.path.join(self.work, name)
        if not os.path.exists(path):
            print(f"  making {name}", file=sys.stderr)
            build(path)
        return path

    def run(self, name, command):
        return self.make(name, lambda path: subprocess.run([self.mesotex, *command, "-o", path, "-q"], check=True))

    def sample(self, size, views="fibonacci:12", preset="weave"):
        name = f"{preset}-{size}-{views.replace(':', '')}.sample"
        return self.run(name, ["bake", "--preset", preset, "--size", str(size), "--views", views, "--lights", views])

    def textons(self, size, views="fibonacci:12"):
        sample = self.sample(size, views)
        return self.run(f"{size}-{views.replace(':', '')}.textons.npz", ["textons", sample, "--textons", "400"])

    def space(self, size):
        return self.run(f"{size}.space.npz", ["gram", self.textons(size)])

    def table(self, size):
        return self.run(f"{size}.knn.npz", ["knn", self.space(size)])

    def mesh(self, columns, rows):
        return self.make(f"torus-{columns}x{rows}.ply", lambda path: torus(path, columns, rows))

    def grid_map(self, size, side):
        command = ["synth", self.space(size), self.table(size), "--grid", f"{side}x{side}"]
        return self.run(f"grid-{size}-{side}.map.ply", command)

    def surface_map(self, size, mesh):
        return self.run(f"surface-{size}.map.ply", ["synth", self.space(size), self.table(size), mesh])

    def pictures(self, count, width, height):
        def build(folder):
            os.makedirs(folder)
            for k in range(count):
                png(os.path.join(folder, f"{k}.png"), width, height, k)
            with open(os.path.join(folder, "lights.lp"), "w") as file:
                file.write(f"{count}\n")
                for k in range(count):
                    angle = 2 * math.pi * k / count
                    file.write(f"{k}.png {0.6 * math.cos(angle):.6f} {0.6 * math.sin(angle):.6f} 0.8\n")

        return self.make(f"pictures-{count}-{width}x{height}", build)


def stages(i):
    """Name, command and output of every stage; the last argument is the output's option."""
    big, out = lambda: i.mesh(1000, 1000), lambda name: os.path.join(i.work, "out", name)
    middle = lambda: i.mesh(500, 500)
    return {
        "bake-one-image": lambda: ["bake", "--preset", "cobbles", "--size", "4096", "--samples", "1024", "--bounces",
                                   "4", "--views", "fibonacci:1", "--lights", "fibonacci:1", "-o", out("a.sample")],
        "bake-many": lambda: ["bake", "--preset", "weave", "--size", "512", "--preview", out("b.png"), "--surface",
                              out("b.npz"), "-o", out("b.sample")],
        "import": lambda: ["import", os.path.join(i.pictures(6, 5000, 4000), "lights.lp"), "-o", out("c.sample")],
        "textons-128": lambda: ["textons", i.sample(128, "12x5"), "-o", out("d.textons.npz")],
        "textons-all": lambda: ["textons", i.sample(128, "12x5"), "--images", "all", "--restarts", "2", "-o",
                                out("e.textons.npz")],
        "textons-256": lambda: ["textons", i.sample(256), "--textons", "1000", "--montage", out("f.png"),
                                "--label-map", out("g.png"), "-o", out("f.textons.npz")],
        "gram": lambda: ["gram", i.textons(128), "-o", out("g.space.npz")],
        "knn-exact": lambda: ["knn", i.space(256), "--search", "exact", "-o", out("h.knn.npz")],
        "knn-two-level": lambda: ["knn", i.space(256), "-o", out("i.knn.npz")],
        "exemplar": lambda: ["exemplar", os.path.join(i.pictures(1, 1024, 1024), "0.png"), "-o", out("j")],
        "mesh-polygon": lambda: ["mesh", i.make("polygon.obj", lambda p: polygon(p, 200_000)), "-o", out("k.ply")],
        "mesh-retile": lambda: ["mesh", middle(), "--vertices", "1000000", "-o", out("l.ply")],
        "mesh-prepare": lambda: ["mesh", big(), "--report", out("m.json"), "--pictures", out("m"), "-o",
                                 out("m.ply")],
        "mesh-curvature": lambda: ["mesh", big(), "--align", "curvature", "--orient", "-o", out("n.ply")],
        "synth-mesh": lambda: ["synth", i.space(128), i.table(128), big(), "--report", out("o.json"), "--pictures",
                               out("o"), "-o", out("o.map.ply")],
        "synth-full": lambda: ["synth", i.space(128), i.table(128), "--grid", "512x512", "--search", "full", "-o",
                               out("p.map.ply")],
        "synth-gram": lambda: ["synth", i.space(128), i.table(128), "--grid", "512x512", "--metric", "gram", "-o",
                               out("q.map.ply")],
        "synth-grid": lambda: ["synth", i.space(128), i.table(128), "--grid", "2048x2048", "-o", out("r.map.ply")],
        "render-8k": lambda: ["render", i.sample(128), i.surface_map(128, middle()), "--size", "8192x8192",
                               "--samples", "1", "-o", out("s")],
        "render-pixel": lambda: ["render", i.sample(128), i.surface_map(128, middle()), "--size", "3840x2160",
                                 "--shading", "pixel", "--samples", "16", "-o", out("t")],
        "render-shadows": lambda: ["render", i.sample(128), i.surface_map(128, middle()), "--shadows", "pixel",
                                   "--light-radius", "5", "--shadow-rays", "256", "--size", "2000x2000", "-o",
                                   out("u")],
        "render-table": lambda: ["render", i.sample(512, "12x5"), i.grid_map(128, 512), "--size", "64x64", "-o",
                                 out("v")],
        "render-sweep": lambda: ["render", i.sample(128), i.surface_map(128, middle()), "--sweep", "light-azimuth",
                                 "--frames", "64", "--animation", "gif", "-o", out("w")],
        "info-sample": lambda: ["info", i.sample(512, "12x5")],
        "demo": lambda: ["demo", "-o", out("demo")],
    }


def clear(work):
    shutil.rmtree(os.path.join(work, "out"), ignore_errors=True)
    for name in os.listdir(work):
        if name.endswith(".mesotex-cache"):
            shutil.rmtree(os.path.join(work, name))
    os.makedirs(os.path.join(work, "out"))


def begin(mesotex, command):
    return subprocess.Popen([mesotex, *command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def whole(mesotex, command, longest):
    """Seconds of an uninterrupted run, at most `longest`."""
    begun = time.monotonic()
    process = begin(mesotex, command)
    try:
        _, said = process.communicate(timeout=longest)
        if process.returncode != 0:
            raise SystemExit(f"{' '.join(command)}: {said}")
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
    return time.monotonic() - begun


def interrupted(mesotex, command, moment, number):
    """Seconds from the signal to the exit, the exit code and what was said; None if it was too late."""
    process = begin(mesotex, command)
    try:
        process.communicate(timeout=moment)
        return None
    except subprocess.TimeoutExpired:
        pass
    sent = time.monotonic()
    process.send_signal(number)
    _, said = process.communicate()
    return time.monotonic() - sent, process.returncode, said


def measure(options, name, command):
    """Prints the row of one stage; hands back whether all was well."""
    clear(options.work)
    number = getattr(signal, "SIG" + options.signal)
    seconds = whole(options.mesotex, command, options.longest)
    worst, met, ended, tried, well = 0.0, 0.0, 0, 0, True
    for k in range(options.moments):
        clear(options.work)
        moment = max(0.05, seconds * (k + 0.5) / options.moments)
        result = interrupted(options.mesotex, command, moment, number)
        if result is None or result[1] == 0:
            continue
        latency, code, said = result
        tried += 1
        ended += latency >= GRACE
        if latency > worst:
            worst, met = latency, moment
        if code != 128 + number or "hint:" not in said or latency >= LIMIT:
            well = False
            print(f"  {name} at {moment:.2f} s: exit {code} after {latency:.2f} s: {said}", file=sys.stderr)
    print(f"| {name:<16} | {seconds:7.1f} | {tried:5} | {worst:6.2f} | {met:7.1f} | {ended:5} |", flush=True)
    return well


def main():
    options = arguments()
    options.mesotex = os.path.abspath(options.mesotex)
    os.makedirs(options.work, exist_ok=True)
    chosen = [name for name in options.stages.split(",") if name]
    print("| stage            | run (s) | tried | worst  | at (s)  | ended |")
    print("| ---------------- | ------: | ----: | -----: | ------: | ----: |")
    well = True
    for name, command in stages(Inputs(options.mesotex, options.work)).items():
        if not chosen or any(name.startswith(begin) for begin in chosen):
            well &= measure(options, name, command())
    shutil.rmtree(os.path.join(options.work, "out"), ignore_errors=True)
    sys.exit(0 if well else 1)


if __name__ == "__main__":
    main()
