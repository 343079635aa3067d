#!/usr/bin/env python3
"""Synthesizes crops of materials, which do not tile, and measures how evenly their texels are used.

    tools/compare_crops.py bark facade leather paving --mesh bunny.obj --program target/release/mesotex

Each argument is a folder with `albedo.png`, `height.png` and `roughness.png`. Of each, four square crops of every
one of `--sizes` texels are baked, analysed and synthesized on a flat grid and on the mesh, retiled to `--vertices`,
with `--seeds` seeds each. Prints a Markdown table: medians and maxima of `histogram_chi2`, medians of
`coherence_one` and `energy_ratio_full`, per material, size and target.

With `--sheet FOLDER` a picture per material and size is kept there: the four crops, and beside each the flat grid of
the first seed. Spaces are kept in `--folder` and used again. `--knn` and `--synth` hand on options to these commands:
`--knn "--margin full"` is the rule of earlier tables.

Needs: pip install numpy pillow
"""

import argparse
import json
import shlex
import statistics
import subprocess
from pathlib import Path

import numpy
from PIL import Image

# Upper left corners of the crops, as shares of what is left of the image's sides.
PLACES = ((0.1, 0.15), (0.8, 0.2), (0.25, 0.75), (0.7, 0.9))
MAPS = ("albedo", "height", "roughness")
DEPTH = 0.05
MATERIAL = """\
height = "height.png"
depth = {depth}
albedo = "albedo.png"
roughness = "roughness.png"
tileable = false
"""
FIGURES = ("histogram_chi2", "coherence_one", "energy_ratio_full")


class Runs:
    """Runs of the program, and where their products are kept."""

    def __init__(self, args):
        self.args, self.folder = args, args.folder

    def run(self, *words):
        words = [str(word) for word in (self.args.program, *words, "--quiet")]
        if self.args.threads:
            words += ["--threads", str(self.args.threads)]
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.stderr}")

    def crop(self, source, size, place):
        """The folder of a crop's maps."""
        folder = self.folder / f"{source.name}-{size}-{place}"
        if not (folder / "material.toml").exists():
            folder.mkdir(parents=True, exist_ok=True)
            width = 0
            for name in MAPS:
                image = Image.open(source / f"{name}.png")
                width = image.width
                left, top = (round(share * (side - size)) for share, side in zip(PLACES[place], image.size))
                image.crop((left, top, left + size, top + size)).save(folder / f"{name}.png")
            (folder / "material.toml").write_text(MATERIAL.format(depth=DEPTH * width / size))
        return folder

    def space(self, crop, size):
        """The surface texton space of a crop."""
        space = crop.with_suffix(".space.npz")
        if not space.exists():
            sample, textons = crop.with_suffix(".sample"), crop.with_suffix(".textons.npz")
            directions = ("--views", self.args.directions, "--lights", self.args.directions)
            if not sample.exists():
                self.run("bake", crop, "-o", sample, "--size", size, "--samples", 1, *directions)
            self.run("textons", sample, "-o", textons, "--textons", self.args.textons, "--images", "all")
            self.run("gram", textons, "-o", space)
        return space

    def table(self, space):
        """The neighbour table, made anew: it depends on the program and on `--knn`."""
        table = space.with_suffix("").with_suffix(".knn.npz")
        self.run("knn", space, "-o", table, *shlex.split(self.args.knn))
        return table

    def mesh(self):
        """The mesh, retiled."""
        mesh = self.folder / f"{self.args.mesh.stem}-{self.args.vertices}.ply"
        if not mesh.exists():
            self.run("mesh", self.args.mesh, "-o", mesh, "--vertices", self.args.vertices)
        return mesh

    def synthesize(self, exemplar, target, output, seed):
        """The quality figures of a map."""
        report = output.with_suffix(".json")
        words = ("synth", *exemplar, *target, "-o", output, "--seed", seed, "--report", report)
        self.run(*words, *shlex.split(self.args.synth))
        return json.loads(report.read_text())


def map_coordinates(path, side):
    """The s and t of a flat map, [side, side, 2]."""
    raw = path.read_bytes()
    head, body = raw.split(b"end_header\n", 1)
    names, kinds = [], []
    for line in head.decode().splitlines():
        words = line.split()
        if words[:2] == ["element", "face"]:
            break
        if words[:1] == ["property"]:
            kinds.append({"float": "<f4", "double": "<f8", "ushort": "<u2", "uchar": "u1", "uint": "<u4"}[words[1]])
            names.append(words[2])
    vertices = numpy.frombuffer(body, dtype=list(zip(names, kinds)), count=side * side)
    order = numpy.lexsort((vertices["x"], -vertices["y"]))
    return numpy.stack([vertices["s"], vertices["t"]], axis=1)[order].reshape(side, side, 2)


def drawn(crop, flat, side):
    """The colours of a flat map."""
    colors = numpy.asarray(Image.open(crop / "albedo.png").convert("RGB"))
    coords = map_coordinates(flat, side)
    height, width = colors.shape[:2]
    rows = numpy.clip(numpy.floor(height - coords[..., 1]).astype(int), 0, height - 1)
    cols = numpy.clip(numpy.floor(coords[..., 0]).astype(int), 0, width - 1)
    return colors, colors[rows, cols]


def sheet(pairs, side):
    """Crops and what was made of them, in two columns of two."""
    gap, wide = 8, max(colors.shape[1] for colors, _ in pairs)
    page = numpy.full((2 * side + gap, 2 * (wide + side + 2 * gap), 3), 255, numpy.uint8)
    for at, (colors, flat) in enumerate(pairs):
        top, left = at // 2 * (side + gap), at % 2 * (wide + side + 2 * gap)
        page[top : top + colors.shape[0], left : left + colors.shape[1]] = colors
        page[top : top + side, left + wide + gap : left + wide + gap + side] = flat
    return Image.fromarray(page)


def measure(runs, source, size):
    """Figures per target of all crops and seeds."""
    args, found, pairs = runs.args, {}, []
    for place in range(len(PLACES)):
        crop = runs.crop(source, size, place)
        space = runs.space(crop, size)
        exemplar = (space, runs.table(space))
        targets = {"grid": ("--grid", f"{args.grid}x{args.grid}")}
        if args.mesh:
            targets[args.mesh.stem] = (runs.mesh(),)
        for name, target in targets.items():
            for seed in range(args.seeds):
                output = runs.folder / f"{name}-{seed}.map.ply"
                report = runs.synthesize(exemplar, target, output, seed)
                found.setdefault(name, []).append([report[figure] for figure in FIGURES])
                if name == "grid" and seed == 0:
                    pairs.append(drawn(crop, output, args.grid))
    if args.sheet:
        args.sheet.mkdir(parents=True, exist_ok=True)
        sheet(pairs, args.grid).save(args.sheet / f"{source.name}-{size}.png")
    return found


def row(words, figures):
    """A line of the table."""
    chi2, coherence, ratio = zip(*figures)
    medians = (statistics.median(chi2), max(chi2), statistics.median(coherence), statistics.median(ratio))
    print("| " + " | ".join([*words, *(f"{figure:.3f}" for figure in medians)]) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("materials", nargs="+", type=Path)
    parser.add_argument("--program", type=Path, default=Path("target/release/mesotex"))
    parser.add_argument("--folder", type=Path, default=Path("crops"))
    parser.add_argument("--mesh", type=Path)
    parser.add_argument("--vertices", type=int, default=40_000)
    parser.add_argument("--grid", type=int, default=256)
    parser.add_argument("--sizes", type=int, nargs="+", default=[64, 128])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--textons", type=int, default=200)
    parser.add_argument("--directions", default="fibonacci:20")
    parser.add_argument("--knn", default="")
    parser.add_argument("--synth", default="")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--sheet", type=Path)
    runs = Runs(parser.parse_args())
    args, totals = runs.args, {}
    print("| crops of | texels | target | χ², median | χ², most | coherence | energy ratio |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for source in args.materials:
        for size in args.sizes:
            for target, figures in measure(runs, source, size).items():
                row((source.name, str(size), target), figures)
                totals.setdefault(target, []).extend(figures)
    for target, figures in totals.items():
        row(("all", "", target), figures)


if __name__ == "__main__":
    main()
