#!/usr/bin/env python3
"""Repeats the tables and figures of Tong 2002, with the built-in material and a mesh, by one command.

Needs: pip install numpy pillow; about 15 minutes on two cores.

    tools/reproduce_paper.py MESH -o docs/images/reproduction --program target/release/mesotex

MESH is any closed mesh; the built-in one is `demo/kettlebell.ply`, after `mesotex demo`. Prints Table 1
(synthesis times for k 1 and 11, samples of 64, 96 and 128 texels, 250,000 and 300,000 vertices), Table 2
(full search against k-coherence on 25,000 vertices), the quality figures of Fig. 6 (flat synthesis, k 1, 5,
11 and full) and of Fig. 9 (both searches on the surface under one light), as Markdown, and writes the
pictures of both figures. `--only table1,table2,figure6,figure9` chooses among them.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

SIZES = (64, 96, 128)
PAPER_FULL_OVER_COHERENT = {64: "about 10"}


class Chain:
    """The stages' files in one folder; each is made when it is first asked for."""

    def __init__(self, args, folder):
        self.args, self.folder = args, Path(folder)

    def run(self, *words):
        words = [str(word) for word in (self.args.program, *words)]
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.stderr}")
        return done.stdout

    def made(self, name, *words):
        path = self.folder / name
        if not path.exists():
            self.run(*words, "-o", path, "--quiet")
        return path

    def sample(self, size):
        return self.made(
            f"{size}.sample", "bake", "--preset", self.args.preset, "--size", size,
            "--views", "fibonacci:40", "--lights", "fibonacci:40",
        )  # fmt: skip

    def exemplar(self, size):
        """Space and table of a sample, with 11 neighbours per texel."""
        textons = self.made(f"{size}.textons.npz", "textons", self.sample(size))
        space = self.made(f"{size}.space.npz", "gram", textons)
        return space, self.made(f"{size}.knn.npz", "knn", space)

    def mesh(self, vertices):
        return self.made(f"{vertices}.ply", "mesh", self.args.mesh, "--vertices", vertices)

    def synthesize(self, name, size, target, *options):
        """Report of a synthesis; its map is `name`.map.ply."""
        output = self.folder / f"{name}.map.ply"
        return json.loads(self.run("synth", *self.exemplar(size), *target, "-o", output, "--json", *options))

    def seconds(self, *arguments):
        return self.synthesize("timed", *arguments)["seconds"]["synthesis"]


def table1(chain):
    print("\n## Table 1: seconds of synthesis\n")
    print("| sample | k | 250,000 vertices | 300,000 vertices |\n| --- | --- | --- | --- |")
    for size in SIZES:
        for k in (1, 11):
            times = [chain.seconds(size, [chain.mesh(n)], "--k", k) for n in (250_000, 300_000)]
            print(f"| {size} × {size} | {k} | {times[0]:.2f} | {times[1]:.2f} |", flush=True)


def table2(chain):
    print("\n## Table 2: full search against k-coherence, 25,000 vertices\n")
    print("| sample | k-coherence, k 11 | full search | ratio | paper's ratio |\n| --- | --- | --- | --- | --- |")
    mesh = chain.mesh(25_000)
    for size in SIZES:
        coherent, full = (chain.seconds(size, [mesh], "--search", search) for search in ("k-coherence", "full"))
        paper = PAPER_FULL_OVER_COHERENT.get(size, "more")
        print(f"| {size} × {size} | {coherent:.2f} s | {full:.2f} s | {full / coherent:.1f} | {paper} |", flush=True)


def quality(report):
    names = ("energy_ratio_full", "coherence_one", "histogram_chi2")
    return " | ".join(f"{report[name]:.3f}" for name in names) + f" | {report['seconds']['synthesis']:.2f}"


QUALITY = "energy over the best texels' | coherence within one texel | χ² of labels | seconds |"


def side_by_side(paths, target):
    pictures = [Image.open(path).convert("RGB") for path in paths]
    width = sum(picture.width for picture in pictures) + 8 * (len(pictures) - 1)
    sheet = Image.new("RGB", (width, pictures[0].height), "white")
    left = 0
    for picture in pictures:
        sheet.paste(picture, (left, 0))
        left += picture.width + 8
    sheet.save(target, quality=88)


def figure6(chain):
    print(f"\n## Fig. 6: flat synthesis, 256 × 256 from 64 × 64\n\n| search | {QUALITY}\n| --- | --- | --- | --- | --- |")
    pictures = []
    for name, options in (("k 1", ["--k", 1]), ("k 5", ["--k", 5]), ("k 11", ["--k", 11]), ("full", ["--search", "full"])):
        stem = chain.folder / name.replace(" ", "")
        shown = ["--pictures", stem, "--sample", chain.sample(64)]
        report = chain.synthesize("flat", 64, [], "--grid", "256x256", *options, *shown)
        print(f"| {name} | {quality(report)} |", flush=True)
        pictures.append(f"{stem}.color.png")
    side_by_side(pictures, chain.args.output / "figure6.jpg")


def figure9(chain):
    print(f"\n## Fig. 9: both searches on the surface\n\n| search | {QUALITY}\n| --- | --- | --- | --- | --- |")
    pictures = []
    for search in ("k-coherence", "full"):
        report = chain.synthesize(search, 64, [chain.mesh(25_000)], "--search", search)
        print(f"| {search} | {quality(report)} |", flush=True)
        frames = chain.folder / f"frames-{search}"
        chain.run("render", chain.sample(64), chain.folder / f"{search}.map.ply", "-o", frames, "--frames", 1, "--size", "480x480", "--quiet")
        pictures.append(frames / "frame.0001.png")
    side_by_side(pictures, chain.args.output / "figure9.jpg")


PARTS = {"table1": table1, "table2": table2, "figure6": figure6, "figure9": figure9}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--program", default="target/release/mesotex")
    parser.add_argument("--preset", default="weave")
    parser.add_argument("--only", default=",".join(PARTS), help="parts, separated by commas")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for part in args.only.split(","):
            PARTS[part](Chain(args, folder))


if __name__ == "__main__":
    main()
