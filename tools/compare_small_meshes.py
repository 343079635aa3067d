#!/usr/bin/env python3
"""Measures how evenly small meshes and meshes with limbs use their sample.

    tools/compare_small_meshes.py bunny.obj spot.obj fertility.off --materials bark leather --presets cobbles weave \
        --program target/release/mesotex

Every material (a folder that `bake` reads) and preset is baked with `--size` texels and analysed; every mesh is retiled
to each of the `--vertices`; every pair is synthesized with `--seeds` seeds. Prints a Markdown table: per sample, mesh and
number of vertices the levels that were chosen, medians and maxima of `histogram_chi2`, medians of `coherence_one` and
`energy_ratio_full`, and the same of all.

Spaces and meshes are kept in `--folder` and used again. `--synth` hands on options, as in `--synth "--levels 4"`.
"""

import argparse
import json
import shlex
import statistics
import subprocess
from pathlib import Path

FIGURES = ("histogram_chi2", "coherence_one", "energy_ratio_full")


class Runs:
    """Runs of the program, and where their products are kept."""

    def __init__(self, args):
        self.args, self.folder = args, args.folder
        self.folder.mkdir(parents=True, exist_ok=True)

    def run(self, *words):
        words = [str(word) for word in (self.args.program, *words, "--quiet")]
        if self.args.threads:
            words += ["--threads", str(self.args.threads)]
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.stderr}")

    def exemplar(self, name, source):
        """Space and table of a sample."""
        stem = self.folder / f"{name}-{self.args.size}"
        sample, textons, space, table = (
            stem.with_suffix(end) for end in (".sample", ".textons.npz", ".space.npz", ".knn.npz")
        )
        if not space.exists():
            directions = ("--views", self.args.directions, "--lights", self.args.directions)
            if not sample.exists():
                self.run("bake", *source, "-o", sample, "--size", self.args.size, "--samples", 1, *directions)
            self.run("textons", sample, "-o", textons, "--textons", self.args.textons, "--images", "all")
            self.run("gram", textons, "-o", space)
            self.run("knn", space, "-o", table)
        return space, table

    def mesh(self, source, vertices):
        """A mesh, retiled."""
        mesh = self.folder / f"{source.stem}-{vertices}.ply"
        if not mesh.exists():
            self.run("mesh", source, "-o", mesh, "--vertices", vertices)
        return mesh

    def synthesize(self, exemplar, mesh, seed):
        """The report of a map."""
        output = self.folder / "found.map.ply"
        report = output.with_suffix(".json")
        words = ("synth", *exemplar, mesh, "-o", output, "--seed", seed, "--report", report)
        self.run(*words, *shlex.split(self.args.synth))
        return json.loads(report.read_text())


def row(words, reports):
    """A line of the table."""
    chi2, coherence, ratio = ([report[figure] for report in reports] for figure in FIGURES)
    medians = (statistics.median(chi2), max(chi2), statistics.median(coherence), statistics.median(ratio))
    levels = "/".join(sorted({str(report["levels"]) for report in reports}))
    print("| " + " | ".join([*words, levels, *(f"{figure:.3f}" for figure in medians)]) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("--materials", nargs="*", type=Path, default=[])
    parser.add_argument("--presets", nargs="*", default=[])
    parser.add_argument("--program", type=Path, default=Path("target/release/mesotex"))
    parser.add_argument("--folder", type=Path, default=Path("small"))
    parser.add_argument("--vertices", type=int, nargs="+", default=[12_000, 60_000])
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--textons", type=int, default=200)
    parser.add_argument("--directions", default="fibonacci:20")
    parser.add_argument("--synth", default="")
    parser.add_argument("--threads", type=int, default=0)
    runs = Runs(parser.parse_args())
    args, total = runs.args, []
    sources = {path.name: (path,) for path in args.materials}
    sources |= {preset: ("--preset", preset) for preset in args.presets}
    print("| sample | mesh | vertices | levels | χ², median | χ², most | coherence | energy ratio |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, source in sources.items():
        exemplar = runs.exemplar(name, source)
        for path in args.meshes:
            for vertices in args.vertices:
                mesh = runs.mesh(path, vertices)
                reports = [runs.synthesize(exemplar, mesh, seed) for seed in range(args.seeds)]
                row((name, path.stem, f"{vertices:,}"), reports)
                total += reports
    row(("all", "", ""), total)


if __name__ == "__main__":
    main()
