#!/usr/bin/env python3
"""Repeats figures of Castellanos and Williams with `synth --method choosy`, by one command.

    tools/reproduce_castellanos.py FOLDER --program target/release/mesotex

FOLDER is one of tools/draw_exemplars.py: its rust, marble (`pale.png`), water, burl and candy, and its sphere. Prints Markdown:

- histograms (Fig. 13) of 131,072 faces, and of as many vertices by `--method wei-levoy`: Σ |a − b| of 50 bins over the
  8-bit numbers of a channel, the largest of three; 0 is the sample's own and 2 the largest possible;
- eigenvalues of neighbourhoods on the finest level (Table 1): the first over the second and over the twentieth;
- iterations on every level (Fig. 10), and 20 against 108 dimensions (Fig. 19);
- sizes: seconds of synthesis and peak memory of the whole run.

Needs: pip install numpy pillow
"""

import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

SAMPLES = ("rust", "pale", "water", "burl", "candy")
# The sphere has 2,048 triangles; three subdivisions make 131,072 faces.
GLOBE, SUBDIVISIONS = 2_048, 3
FACES = GLOBE * 4**SUBDIVISIONS
BINS = 50
KINDS = {"float": "<f4", "double": "<f8", "uchar": "u1", "ushort": "<u2"}


class Runs:
    """Runs of one program in one folder."""

    def __init__(self, program, drawn, folder):
        self.program, self.drawn, self.folder = program, drawn, folder

    def run(self, *words):
        """The report of a run, and the most memory that it took, in MiB."""
        words = [str(word) for word in (self.program, *words, "--json")]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=self.folder)
        told, said = process.stdout.read(), process.stderr.read()
        _, status, usage = os.wait4(process.pid, 0)
        if status:
            raise SystemExit(f"{' '.join(words)}: {said}")
        return json.loads(told), usage.ru_maxrss / 1024

    def exemplar(self, sample):
        if not (self.folder / f"{sample}.space.npz").exists():
            self.run("exemplar", self.drawn / f"{sample}.png", "-o", sample)
        return f"{sample}.space.npz", f"{sample}.knn.npz"

    def faces(self, sample, *more, base=GLOBE, subdivisions=SUBDIVISIONS):
        space, _ = self.exemplar(sample)
        words = ("synth", space, self.drawn / "globe.obj", "-o", "found.faces.ply", "--method", "choosy")
        return self.run(*words, "--base-faces", base, "--subdivisions", subdivisions, *more)

    def by_vertices(self, sample):
        """The largest distance of histograms of a map by Wei and Levoy's method, of as many vertices as faces."""
        sphere = self.folder / "sphere.ply"
        if not sphere.exists():
            self.run("mesh", self.drawn / "globe.obj", "--vertices", FACES, "-o", sphere)
        self.run("synth", *self.exemplar(sample), sphere, "-o", "found.map.ply", "--method", "wei-levoy")
        vertices = vertices_of(self.folder / "found.map.ply")
        pixels = np.asarray(Image.open(self.drawn / f"{sample}.png").convert("RGB"))
        height, width, _ = pixels.shape
        rows = np.clip(height - vertices["t"], 0, height - 1).astype(int)
        cols = np.clip(vertices["s"], 0, width - 1).astype(int)
        return largest_distance(pixels.reshape(-1, 3), pixels[rows, cols])


def vertices_of(path):
    """The vertices of a binary PLY."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    begin = next(at for at, line in enumerate(lines) if line.startswith("element vertex"))
    properties = []
    for line in lines[begin + 1 :]:
        if not line.startswith("property"):
            break
        properties.append((line.split()[2], KINDS[line.split()[1]]))
    return np.frombuffer(body, dtype=properties, count=int(lines[begin].split()[-1]))


def largest_distance(sample, found):
    shares = lambda numbers: np.histogram(numbers, BINS, (0, 255))[0] / len(numbers)
    return max(np.abs(shares(sample[:, at]) - shares(found[:, at])).sum() for at in range(3))


def table(head, rows):
    print(f"| {' | '.join(head)} |\n|{' --- |' * len(head)}")
    for row in rows:
        print(f"| {' | '.join(row)} |", flush=True)
    print()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drawn", type=Path, metavar="FOLDER")
    parser.add_argument("--program", default="target/release/mesotex", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(args.program.resolve(), args.drawn.resolve(), Path(folder))

        def histograms(sample):
            report, _ = runs.faces(sample)
            first = report["eigenvalues"][-1]
            ratios = [f"{first[0] / first[at]:.0f}" for at in (1, 19)]
            by_faces, by_vertices = report["histogram_l1"], runs.by_vertices(sample)
            return sample, f"{by_faces:.3f}", f"{by_vertices:.3f}", *ratios

        def variant(sample, *more):
            report, _ = runs.faces(sample, *more)
            return sample, " ".join(more), f"{report['seconds']['synthesis']:.1f}", f"{report['histogram_l1']:.3f}"

        def size(base, subdivisions):
            report, memory = runs.faces("rust", base=base, subdivisions=subdivisions)
            return f"{report['faces']:,}", f"{report['seconds']['synthesis']:.1f}", f"{memory:.0f} MiB"

        head = ("sample", "choosy", "Wei–Levoy", "first eigenvalue over the second", "over the twentieth")
        table(head, map(histograms, SAMPLES))
        options = [("--iterations", "1"), ("--iterations", "2"), ("--iterations", "4"), ("--dimensions", "108")]
        rows = (variant(sample, *more) for sample in ("rust", "candy") for more in options)
        table(("sample", "options", "synthesis, s", "histograms"), rows)
        table(("faces", "synthesis, s", "memory"), (size(*of) for of in ((GLOBE, 3), (GLOBE, 4), (3_752, 4))))


if __name__ == "__main__":
    main()
