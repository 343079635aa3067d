#!/usr/bin/env python3
"""Compares mesotex with `texture-synthesis` 0.8.3 on flat pictures, in one run.

For every exemplar picture (PNG) both programs synthesize a picture of the same size. The figure is the
sliced Wasserstein distance of 7x7 patches at 3 scales to the exemplar (smaller is closer), and the seconds
from picture to picture; of ours also those of synthesis alone, without the neighbour table, the quality
figures and the pictures of the map that the commands make as well.

Needs: pip install numpy pillow; both programs on the PATH or named:
  cargo install --locked texture-synthesis-cli
Run:
  tools/compare_texture.py --mesotex target/release/mesotex --size 256 a.png b.png ...
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image


def pixels(path):
    return np.asarray(Image.open(path).convert("RGB"), dtype=np.float64) / 255.0


def halved(image):
    height, width = (side // 2 * 2 for side in image.shape[:2])
    image = image[:height, :width]
    return (image[::2, ::2] + image[1::2, ::2] + image[::2, 1::2] + image[1::2, 1::2]) / 4.0


def patches(image, side=7):
    windows = np.lib.stride_tricks.sliding_window_view(image, (side, side), axis=(0, 1))
    return windows.reshape(-1, side * side * image.shape[2])


def sliced_wasserstein(a, b, directions=256, quantiles=512, seed=0):
    """Mean over random directions of the distance of the projections' quantile functions."""
    axes = np.random.default_rng(seed).normal(size=(a.shape[1], directions))
    axes /= np.linalg.norm(axes, axis=0)
    at = (np.arange(quantiles) + 0.5) / quantiles
    distance = np.quantile(a @ axes, at, axis=0) - np.quantile(b @ axes, at, axis=0)
    return np.sqrt((distance**2).mean())


def patch_distance(found, exemplar, scales=3):
    total = 0.0
    for _ in range(scales):
        total += sliced_wasserstein(patches(found), patches(exemplar)) / scales
        found, exemplar = halved(found), halved(exemplar)
    return total


def timed(*command):
    """Seconds a command takes, and what it prints."""
    begin = time.perf_counter()
    done = subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True)
    return time.perf_counter() - begin, done.stdout


def ours(program, picture, size, folder):
    """The picture, and the seconds in all and of synthesis alone."""
    name = folder / "ours"
    prepared, _ = timed(program, "exemplar", picture, "-o", name)
    seconds, report = timed(program, "synth", f"{name}.space.npz", f"{name}.knn.npz", "--grid", f"{size}x{size}",
                            "-o", f"{name}.map.ply", "--pictures", name, "--sample", f"{name}.sample", "--json")
    alone = json.loads(report)["seconds"]["synthesis"]
    return Path(f"{name}.color.png"), prepared + seconds, alone


def theirs(program, picture, size, folder):
    """The picture, and the seconds in all."""
    out = folder / "theirs.png"
    seconds, _ = timed(program, "--out-size", f"{size}x{size}", "--out", out, "generate", picture)
    return out, seconds


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("pictures", nargs="+", type=Path)
    arguments.add_argument("--size", type=int, default=256)
    arguments.add_argument("--mesotex", default="mesotex")
    arguments.add_argument("--peer", default="texture-synthesis")
    options = arguments.parse_args()
    closer, totals = 0, np.zeros(3)
    print("| exemplar | distance, ours | theirs | seconds, ours | synthesis alone | theirs |")
    print("| --- | --- | --- | --- | --- | --- |")
    for picture in options.pictures:
        with tempfile.TemporaryDirectory() as folder:
            found, seconds, alone = ours(options.mesotex, picture, options.size, Path(folder))
            peers, their_seconds = theirs(options.peer, picture, options.size, Path(folder))
            exemplar = pixels(picture)
            a, b = (patch_distance(pixels(path), exemplar) for path in (found, peers))
        closer += a < b
        totals += seconds, alone, their_seconds
        print(f"| {picture.stem} | {a:.4f} | {b:.4f} | {seconds:.2f} | {alone:.2f} | {their_seconds:.2f} |", flush=True)
    whole, synthesis = totals[2] / totals[:2]
    print(f"\ncloser to the exemplar: {closer} of {len(options.pictures)}")
    print(f"times as fast: {whole:.1f} from picture to picture, {synthesis:.1f} by synthesis alone")


if __name__ == "__main__":
    main()
