#!/usr/bin/env python3
"""Compares a GLB in a browser with the frame that `mesotex render` draws of the same surface.

    mesotex render A.sample A.atlas -o frames --frames 1 --size 1280x1280 --shading pixel --texels bilinear \
        --shadows none
    tools/compare_glb.py frames/frame.0001.exr A.atlas/surface.glb …

Arguments are pairs of a frame and a GLB. `tools/draw_glb.mjs` draws the GLB with three.js in headless Chromium: Lambertian, with
the frame's camera and directional light, linear, in twice the columns and rows (`--supersampling`). `render` shades each pixel
once. So that texture finer than a pixel is filtered alike, means over blocks of 4 × 4 pixels of the frame (`--block`)
are compared, set on black and put through the sRGB curve. Only blocks count that both cover wholly, less those
with a neighbour that is not: no edge of the mask counts. Prints per pair the number of blocks, the share of
covered blocks where only one of the two is mostly covered, the mean and the 95th percentile of |a − b| over the
channels, in 255ths, the mean of a − b, and the share of blocks with a channel that differs by more than 8.

`--control v|green|gamma|cutoff|side` draws the GLB with a fault on purpose: rows of images turned over, green of normal maps
reversed, colours taken as linear, holes cut at 0.95, one side left out. `--pictures FOLDER` writes both and eight times their difference.

Needs: pip install numpy scipy pillow OpenEXR; and what tools/draw_glb.mjs needs, in the folder it is run from or above
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image
from scipy.ndimage import minimum_filter

DRAW = Path(__file__).with_name("draw_glb.mjs")


def read_frame(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        header = dict(file.header())
        pixels = np.stack([file.channels()[name].pixels.astype(np.float64) for name in "RGBA"], -1)
    return header, pixels


def view_of(header, shape, args):
    """What tools/draw_glb.mjs needs of a frame's header; matrices are for row vectors, z is ahead."""
    options = json.loads(header["mesotex:options"])
    if options["projection"] != "perspective" or "lightDirection" not in header:
        raise SystemExit("frames must have a perspective camera and one directional light")
    half = np.tan(np.radians(options["fov"]) / 2) / options.get("zoom", 1.0)
    camera = np.array(header["worldToCamera"], float).reshape(4, 4)
    away = np.linalg.norm(camera[3, :3])
    return {
        "width": shape[1], "height": shape[0], "supersampling": args.supersampling, "fov": float(np.degrees(2 * np.arctan(half))),
        "position": np.linalg.inv(camera)[3, :3].tolist(), "up": camera[:3, 1].tolist(), "ahead": camera[:3, 2].tolist(),
        "near": 0.05 * away, "far": 20.0 * away,
        "light": np.array(header["lightDirection"], float).tolist(), "irradiance": float(header["lightIrradiance"]),
        "control": args.control,
    }


def draw(glb, view):
    with tempfile.TemporaryDirectory() as folder:
        request, out = Path(folder) / "view.json", Path(folder) / "out.f32"
        request.write_text(json.dumps(view))
        subprocess.run(["node", str(DRAW), str(glb), str(request), str(out)], check=True)
        return np.fromfile(out, "<f4").reshape(view["height"], view["width"], 4).astype(np.float64)


def reduced(pixels, side):
    """The mean of each block of side x side pixels."""
    height, width = (length // side for length in pixels.shape[:2])
    return pixels[: height * side, : width * side].reshape(height, side, width, side, 4).mean(axis=(1, 3))


def stored(pixels):
    """0 to 255, on black."""
    values = np.clip(pixels[..., :3], 0.0, 1.0)
    curved = 1.055 * np.maximum(values, 0.0031308) ** (1 / 2.4) - 0.055
    return 255.0 * np.where(values <= 0.0031308, 12.92 * values, curved)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="+", type=Path, metavar="FRAME.exr FILE.glb")
    parser.add_argument("--supersampling", type=int, default=2)
    parser.add_argument("--block", type=int, default=4)
    parser.add_argument("--control", choices=("v", "green", "gamma", "cutoff", "side"))
    parser.add_argument("--pictures", type=Path, metavar="FOLDER")
    args = parser.parse_args()
    if len(args.pairs) % 2:
        parser.error("frames and GLB files come in pairs")
    print("| model | blocks | covered by one | mean | 95 % | bias | beyond 8 |\n| --- | --- | --- | --- | --- | --- | --- |")
    for frame, glb in zip(args.pairs[::2], args.pairs[1::2]):
        header, ours = read_frame(frame)
        theirs = reduced(draw(glb, view_of(header, ours.shape, args)), args.block)
        ours = reduced(ours, args.block)
        covered = np.stack([ours[..., 3], theirs[..., 3]])
        whole = minimum_filter(covered.min(axis=0), 3, mode="constant") > 0.999
        mostly = covered > 0.5
        alone = (mostly[0] != mostly[1]).sum() / max(1, mostly.any(axis=0).sum())
        a, b = stored(ours), stored(theirs)
        apart = np.abs(a - b)[whole]
        bias, beyond = (a - b)[whole].mean(), (apart > 8.0).any(axis=1).mean()
        name = frame.parent.name + (f" ({args.control})" if args.control else "")
        print(f"| {name} | {whole.sum():,} | {alone:.2%} | {apart.mean():.2f} | {np.percentile(apart, 95):.1f} "
              f"| {bias:+.2f} | {beyond:.2%} |", flush=True)
        if args.pictures:
            args.pictures.mkdir(parents=True, exist_ok=True)
            strip = np.concatenate([a, b, np.clip(8.0 * np.abs(a - b), 0.0, 255.0)], axis=1)
            Image.fromarray(np.round(strip).astype(np.uint8)).save(args.pictures / f"{name}.png")


if __name__ == "__main__":
    main()
