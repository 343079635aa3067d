#!/usr/bin/env python3
"""Repeats the timing table of Ying et al. 2001 §6 with `synth --onto atlas`, by one command.

    tools/reproduce_ying.py COW BALL DOG TORUS HORSE EXEMPLAR --program target/release/mesotex

The first five are meshes that stand for the paper's models (its 3D cross among them: the ball's is taken), EXEMPLAR
is an image of which the middle 64, 96, 128 and 192 texels are used. Every mesh is unwrapped. The resolution is
chosen so that the texels inside charts are within 3 % of the paper's. Seconds are those of synthesis and of
preparation (charts, field, neighbourhoods). Prints Markdown.

Needs: pip install pillow
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

# Model, texels in the paper, side of the exemplar, method, the paper's minutes.
ROWS = (
    ("cow", 369_664, 96, "coherent", 3),
    ("cross", 399_360, 64, "multiscale", 10),
    ("ball", 98_304, 64, "multiscale", 2.5),
    ("dog", 696_320, 64, "multiscale", 18),
    ("dog", 174_080, 64, "multiscale", 5),
    ("torus", 114_688, 64, "multiscale", 1.5),
    ("torus", 114_688, 64, "coherent", 0.5),
    ("torus", 114_688, 192, "multiscale", 290),
    ("torus", 114_688, 192, "coherent", 0.5),
    ("cow", 289_792, 128, "coherent", 2),
    ("horse", 275_968, 128, "coherent", 2),
)
WITHIN = 0.03


class Runs:
    """Runs of one program in one folder."""

    def __init__(self, args, folder):
        self.args, self.folder, self.sides = args, folder, {}
        models = dict(zip(("cow", "ball", "dog", "torus", "horse"), args.meshes))
        self.models = {**models, "cross": models["ball"]}

    def run(self, *words):
        words = [str(word) for word in (self.args.program, *words)]
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.stderr}")
        return done.stdout

    def exemplar(self, side):
        """Space and table of the middle part of the image."""
        name = self.folder / f"exemplar{side}"
        if not Path(f"{name}.space.npz").exists():
            image = Image.open(self.args.exemplar).convert("RGB")
            factor = max(1.0, side / min(image.size))
            if factor > 1:
                image = image.resize([round(factor * length) for length in image.size])
            left, top = (image.width - side) // 2, (image.height - side) // 2
            part = self.folder / f"{side}.png"
            image.crop((left, top, left + side, top + side)).save(part)
            self.run("exemplar", part, "-o", name, "--quiet")
        return f"{name}.space.npz", f"{name}.knn.npz"

    def synthesize(self, model, side, method, resolution):
        words = ["synth", *self.exemplar(side), self.models[model], "--onto", "atlas", "--unwrap", "--method", method]
        words += ["--resolution", resolution, "-o", self.folder / "found.atlas", "--json"]
        return json.loads(self.run(*words))

    def row(self, model, texels, side, method):
        """The report of a run at about so many texels inside charts, the quickest of some."""
        resolution = self.sides.get((model, texels), round((texels / 0.6) ** 0.5))
        for _ in range(8):
            report = self.synthesize(model, side, method, resolution)
            if abs(report["vertices"] - texels) <= WITHIN * texels:
                break
            resolution = round(resolution * (texels / report["vertices"]) ** 0.5)
        else:
            raise SystemExit(f"{model}: no resolution has {texels} texels inside charts")
        self.sides[model, texels] = resolution
        others = [self.synthesize(model, side, method, resolution) for _ in range(self.args.repeats - 1)]
        return min([report, *others], key=lambda report: report["seconds"]["synthesis"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs=5, type=Path, metavar="MESH")
    parser.add_argument("exemplar", type=Path, metavar="EXEMPLAR")
    parser.add_argument("--program", default="target/release/mesotex")
    parser.add_argument("--repeats", type=int, default=2)
    args = parser.parse_args()
    print("| paper's model | mesh | texels in the paper | texels | exemplar | method | synthesis, s | preparation, s | paper, min |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(args, Path(folder))
        for model, texels, side, method, minutes in ROWS:
            report = runs.row(model, texels, side, method)
            seconds = report["seconds"]
            times = f"{seconds['synthesis']:.2f} | {seconds['prepare']:.2f} | {minutes:g}"
            mesh = runs.models[model].stem
            found = f"{texels:,} | {report['vertices']:,}"
            print(f"| {model} | {mesh} | {found} | {side}² | {method} | {times} |", flush=True)


if __name__ == "__main__":
    main()
