#!/usr/bin/env python3
"""Repeats the timing table of Zhang et al. 2003 §6 with `synth --method progressive`, by one command.

    tools/reproduce_zhang.py VENUS BUNNY GIRAFFE TIGER HORSE --program target/release/mesotex

The five are meshes that stand for the paper's models; each is retiled to the paper's number of vertices. The exemplars have the paper's
sizes: dots that grow from left to right, drawn here, with their mask and transition. The transition of the surface runs along the longest
side of the mesh. Seconds are those of synthesis and of preparation; the neighbour tables are made before. Prints Markdown.

Needs: pip install numpy pillow
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

# Model, exemplar, vertices, the paper's minutes.
ROWS = (
    ("venus", (512, 128), 192_000, 44),
    ("bunny", (512, 128), 300_000, 104),
    ("giraffe", (384, 96), 106_000, 33),
    ("tiger", (256, 64), 170_000, 51),
    ("horse", (448, 128), 250_000, 39),
)
# Pixels from dot to dot, and radii at both ends.
PITCH, SMALL, LARGE = 12, 1.5, 5.0


def dots(width, height, seed=1):
    """Colour, mask and transition of dots that grow from left to right."""
    random = np.random.default_rng(seed)
    transition = np.broadcast_to(np.linspace(0, 1, width), (height, width))
    rows, cols = np.mgrid[0:height, 0:width]
    away = np.full((height, width), np.inf)
    for number, row in enumerate(range(0, height + PITCH, PITCH)):
        for col in range(-PITCH, width + PITCH, PITCH):
            place = np.array([row, col + PITCH // 2 * (number % 2)]) + random.uniform(-1.5, 1.5, 2)
            radius = SMALL + (LARGE - SMALL) * min(max(place[1] / width, 0), 1)
            away = np.minimum(away, np.hypot(rows - place[0], cols - place[1]) - radius)
    share = np.clip(0.5 - away, 0, 1)[..., None]
    ground, dot = np.array([0.85, 0.7, 0.45]), np.array([0.3, 0.15, 0.08])
    colour = ground + (dot - ground) * share + random.normal(0, 0.015, (height, width, 1))
    return colour, (away < 0).astype(np.uint8), transition


class Runs:
    """Runs of one program in one folder."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def run(self, *words):
        words = [str(word) for word in (self.program, *words)]
        done = subprocess.run(words, capture_output=True, text=True, cwd=self.folder)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.stderr}")
        return done.stdout

    def exemplar(self, size):
        name = "{}x{}".format(*size)
        if not (self.folder / f"{name}.knn.npz").exists():
            colour, mask, transition = dots(*size)
            for part, values in (("color", colour * 255), ("mask", mask), ("transition", transition * 255)):
                image = Image.fromarray(np.clip(np.round(values), 0, 255).astype(np.uint8))
                image.save(self.folder / f"{name}.{part}.png")
            words = f"exemplar {name}.color.png -o {name} --levels 3 --k 20 --mask {name}.mask.png".split()
            words += f"--transition {name}.transition.png --transition-tolerance 0.1".split()
            self.run(*words)
        return f"{name}.space.npz", f"{name}.knn.npz"

    def surface(self, mesh, vertices):
        """The retiled mesh, with keys at both ends of its longest side."""
        retiled = self.folder / f"{mesh.stem}.{vertices}.ply"
        if not retiled.exists():
            self.run("mesh", mesh, "--vertices", vertices, "-o", retiled)
        data = retiled.read_bytes()
        head, body = data.split(b"end_header\n", 1)
        lines = head.decode().splitlines()
        count = int(next(line for line in lines if line.startswith("element vertex")).split()[-1])
        kinds = {"float": "<f4", "double": "<f8", "uchar": "u1", "ushort": "<u2"}
        begin = next(at for at, line in enumerate(lines) if line.startswith("element vertex"))
        properties = []
        for line in lines[begin + 1 :]:
            if not line.startswith("property"):
                break
            properties.append((line.split()[2], kinds[line.split()[1]]))
        table = np.frombuffer(body, dtype=properties, count=count)
        axes = [table[axis] for axis in "xyz"]
        longest = max(axes, key=np.ptp)
        ends = ((int(np.argmin(longest)), 0.05), (int(np.argmax(longest)), 0.95))
        keys = [{"vertex": vertex, "transition": value} for vertex, value in ends]
        (self.folder / "keys.json").write_text(json.dumps({"keys": keys}))
        return retiled


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs=5, type=Path, metavar="MESH")
    parser.add_argument("--program", default="target/release/mesotex", type=Path)
    parser.add_argument("--repeats", type=int, default=2)
    args = parser.parse_args()
    print("| paper's model | mesh | vertices | exemplar | synthesis, s | preparation, s | paper, min | fragments | in the exemplar |")
    print("| --- " * 9 + "|")
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(args.program.resolve(), Path(folder))
        for (model, size, vertices, minutes), mesh in zip(ROWS, args.meshes):
            inputs = (*runs.exemplar(size), runs.surface(mesh.resolve(), vertices))
            words = ("synth", *inputs, "-o", "found.map.ply", "--method", "progressive", "--keys", "keys.json", "--json")
            reports = [json.loads(runs.run(*words)) for _ in range(args.repeats)]
            best = min(reports, key=lambda report: report["seconds"]["synthesis"])
            prepared = max(report["seconds"]["prepare"] for report in reports)
            times = f"{best['seconds']['synthesis']:.1f} | {prepared:.1f} | {minutes}"
            shares = " | ".join(f"{100 * best[key]:.2f} %" for key in ("fragment_share", "exemplar_fragment_share"))
            size = "{}×{}".format(*size)
            print(f"| {model} | {mesh.stem} | {best['vertices']:,} | {size} | {times} | {shares} |", flush=True)


if __name__ == "__main__":
    main()
