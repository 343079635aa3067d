#!/usr/bin/env python3
"""Compares the adaptive similarity of Chen and Dong 2008 (§5.2) with plain sums of squared differences.

Every exemplar is synthesized on a flat grid with `synth --method adaptive`, once with `--similarity adaptive`
and once with `--similarity plain`, everything else the same, for several seeds. The figure is the patch
distance of compare_texture.py (smaller is closer to the exemplar). A ratio below 1 means that the adaptive
similarity is closer.

Exemplars are images (PNG), of which the part in the middle is taken where they are larger than `--part`, and
presets, which are baked from above under one light.

Needs: pip install numpy pillow
Run:
  tools/compare_similarity.py --mesotex target/release/mesotex --presets weave,bricks,cobbles,scales a.png b.png ...
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
from compare_texture import patch_distance, pixels, timed
from PIL import Image

SIMILARITIES = ("adaptive", "plain")


def preset_image(program, preset, side, folder):
    """A preset from above, lit from 30° off the normal; white where a white plane is."""
    sample = folder / f"{preset}.sample"
    timed(program, "bake", "--preset", preset, "--size", side, "--views", "rings:0:1", "--lights", "rings:30:1:135",
          "-o", sample)
    radiance = np.load(sample / "radiance.npy").astype(np.float64)[0, 0]
    linear = np.clip(radiance * np.pi / np.cos(np.radians(30.0)), 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    image = folder / f"{preset}.png"
    Image.fromarray(np.round(255.0 * encoded).astype(np.uint8)).save(image)
    return image


def middle(picture, side, folder):
    """The middle part of an image, at most `side` texels each way; an albedo is named after its folder."""
    image = Image.open(picture).convert("RGB")
    width, height = min(side, image.width), min(side, image.height)
    left, top = (image.width - width) // 2, (image.height - height) // 2
    name = picture.stem if picture.stem != "albedo" else picture.resolve().parent.name
    part = folder / f"{name}.part.png"
    image.crop((left, top, left + width, top + height)).save(part)
    return name, part


def synthesized(options, name, similarity, seed, folder):
    """The picture."""
    stem = folder / similarity
    levels = ["--levels", options.levels] if options.levels else []
    timed(options.mesotex, "synth", f"{name}.space.npz", f"{name}.knn.npz", "--grid",
          f"{options.size}x{options.size}", "--method", "adaptive", "--similarity", similarity,
          "--rings", options.rings, *levels, "--seed", seed, "-o", f"{stem}.map.ply",
          "--pictures", stem, "--sample", f"{name}.sample", "--quiet")
    return pixels(f"{stem}.color.png")


def compared(options, picture, folder):
    """Per similarity and seed: the distance to the exemplar."""
    name = folder / "exemplar"
    timed(options.mesotex, "exemplar", picture, "-o", name)
    exemplar = pixels(picture)
    found = {}
    for similarity in SIMILARITIES:
        runs = (synthesized(options, name, similarity, seed, folder) for seed in range(options.seeds))
        found[similarity] = np.array([patch_distance(image, exemplar) for image in runs])
    return found


def exemplars(options, folder):
    for preset in filter(None, options.presets.split(",")):
        yield preset, preset_image(options.mesotex, preset, options.part, folder)
    for picture in options.pictures:
        yield middle(picture, options.part, folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", nargs="*", type=Path)
    parser.add_argument("--presets", default="", help="names of presets, separated by commas")
    parser.add_argument("--part", type=int, default=64, help="texels each way of an exemplar")
    parser.add_argument("--size", type=int, default=256, help="sites each way of the grid")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--rings", type=int, default=3)
    parser.add_argument("--levels", type=int, help="levels of synthesis [default: the method's]")
    parser.add_argument("--mesotex", default="mesotex")
    options = parser.parse_args()
    ratios, closer, runs = [], 0, 0
    print("| exemplar | adaptive | plain | ratio | seeds closer |")
    print("| --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as shared:
        for name, picture in exemplars(options, Path(shared)):
            with tempfile.TemporaryDirectory() as folder:
                found = compared(options, picture, Path(folder))
            adaptive, plain = (found[similarity] for similarity in SIMILARITIES)
            a, b = adaptive.mean(), plain.mean()
            wins = int((adaptive < plain).sum())
            closer, runs = closer + wins, runs + options.seeds
            ratios.append(a / b)
            print(f"| {name} | {a:.4f} | {b:.4f} | {a / b:.2f} | {wins} of {options.seeds} |", flush=True)
    mean = float(np.exp(np.mean(np.log(ratios))))
    print(f"\nmean ratio (geometric): {mean:.3f}; the adaptive similarity is closer in {closer} of {runs} runs")


if __name__ == "__main__":
    main()
