#!/usr/bin/env python3
"""Repeats the sizes of Chen and Dong 2008 §7 with `synth --method adaptive`, by one command.

    tools/reproduce_chen.py MESH EXEMPLAR... --program target/release/mesotex

MESH is one mesh, which is retiled to all four of the paper's numbers of vertices, or four meshes, in the order
head, space shuttle, bunny, horse. EXEMPLAR is one or more images; seconds are means over them. Which argument
is a mesh is told by its ending.

Per mesh: the seconds for circles (preparation with marching less preparation with the circles in the cache),
for all further work (orientation field, samples, synthesis) with the circles in the cache, and for the same
along another field. Per flat size: the seconds of preparation and synthesis. Every figure is the least of
`--repeats` runs. Reading the exemplar, quality figures and writing are not in them. Prints Markdown.

Needs: pip install pillow
"""

import argparse
import json
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

MESHES = (
    ("head", 1_487, "circles below 10"),
    ("space shuttle", 2_376, "not given"),
    ("bunny", 34_834, "not given"),
    ("horse", 48_485, "circles about 300, the rest 10 to 15"),
)
FLAT = ((360, "about 15"), (512, "about 30"))
MESH_ENDINGS = {".obj", ".ply", ".off", ".stl", ".glb", ".gltf"}
CACHED = "read from the cache"


class Runs:
    """Runs of one program in one folder."""

    def __init__(self, args, folder):
        self.args, self.folder = args, folder

    def run(self, *words):
        words = [str(word) for word in (self.args.program, *words)]
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.stderr}")
        return done.stdout

    def exemplar(self, number, picture):
        """Space and table of the middle part of an image."""
        image = Image.open(picture).convert("RGB")
        side = min(self.args.part, *image.size)
        left, top = (image.width - side) // 2, (image.height - side) // 2
        part = self.folder / f"{number}.png"
        image.crop((left, top, left + side, top + side)).save(part)
        self.run("exemplar", part, "-o", self.folder / f"{number}", "--quiet")
        return self.folder / f"{number}.space.npz", self.folder / f"{number}.knn.npz"

    def synthesize(self, exemplar, *target):
        """The seconds of preparation and of synthesis, and where circles came from."""
        output = self.folder / "found.map.ply"
        report = json.loads(self.run("synth", *exemplar, *target, "--method", "adaptive", "-o", output, "--json"))
        seconds = report["seconds"]
        return seconds["prepare"], seconds["synthesis"], report["circles"]

    def marched(self, exemplar, mesh):
        """The seconds of preparation with nothing in the cache."""
        shutil.rmtree(Path(f"{mesh}.mesotex-cache"), ignore_errors=True)
        prepare, _, circles = self.synthesize(exemplar, mesh)
        assert circles == "marched", circles
        return prepare

    def cached(self, exemplar, mesh, *field):
        """The seconds of preparation, and of it and synthesis, with the circles in the cache."""
        prepare, synthesis, circles = self.synthesize(exemplar, mesh, *field)
        assert circles == CACHED, circles
        return prepare, prepare + synthesis

    def least(self, measure, *arguments):
        return min(measure(*arguments) for _ in range(self.args.repeats))

    def mean(self, measure, exemplars, *arguments):
        """The mean over exemplars of the least of some runs."""
        return sum(self.least(measure, exemplar, *arguments) for exemplar in exemplars) / len(exemplars)


def meshes(runs, given, exemplars):
    print("| paper's model | mesh | vertices | circles | further synthesis | along another field | paper's seconds |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    sources = given * len(MESHES) if len(given) == 1 else given
    for source, (name, vertices, paper) in zip(sources, MESHES):
        mesh = runs.folder / f"{vertices}.ply"
        runs.run("mesh", source, "-o", mesh, "--vertices", vertices, "--quiet")
        marched = runs.least(runs.marched, exemplars[0], mesh)
        prepared = runs.least(lambda: runs.cached(exemplars[0], mesh)[0])
        further = runs.mean(lambda exemplar: runs.cached(exemplar, mesh)[1], exemplars)
        changed = runs.mean(lambda exemplar: runs.cached(exemplar, mesh, "--direction", "0,1,0")[1], exemplars)
        seconds = " | ".join(f"{value:.2f}" for value in (marched - prepared, further, changed))
        print(f"| {name} | {source.stem} | {vertices:,} | {seconds} | {paper} |", flush=True)


def flat(runs, exemplars):
    print("\n| flat | seconds | paper's seconds |\n| --- | --- | --- |")
    for side, paper in FLAT:
        grid = f"{side}x{side}"
        seconds = runs.mean(lambda exemplar: sum(runs.synthesize(exemplar, "--grid", grid)[:2]), exemplars)
        print(f"| {side} × {side} | {seconds:.2f} | {paper} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("inputs", nargs="+", type=Path, metavar="MESH EXEMPLAR")
    parser.add_argument("--program", default="target/release/mesotex")
    parser.add_argument("--part", type=int, default=128, help="texels each way of an exemplar, from its middle")
    parser.add_argument("--repeats", type=int, default=3)
    args = parser.parse_args()
    given = [path for path in args.inputs if path.suffix.lower() in MESH_ENDINGS]
    pictures = [path for path in args.inputs if path not in given]
    if len(given) not in (1, len(MESHES)) or not pictures:
        parser.error("one mesh or four, and at least one image")
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(args, Path(folder))
        exemplars = [runs.exemplar(number, picture) for number, picture in enumerate(pictures)]
        meshes(runs, given, exemplars)
        flat(runs, exemplars)


if __name__ == "__main__":
    main()
