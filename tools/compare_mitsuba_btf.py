#!/usr/bin/env python3
"""Compares a frame of `mesotex render --shading pixel` with the same surface in Mitsuba 3, drawn by the plugin `mesotex.mitsuba`.

    mesotex render A.sample A.map.ply -o frames --frames 1 --size 2560x1920 --samples 1 --shading pixel \
        --shadows pixel --texels bilinear --mip off --parallax off --layers rgba,shadow
    tools/compare_mitsuba_btf.py A.sample A.map.ply frames/frame.0001.exr

`render` shades each pixel once, with `--samples 1` in its centre. So that texture is filtered alike, means over blocks of 4 x 4 pixels
of the frame (`--block`) are compared with pixels of Mitsuba, which sends `--samples` rays through each and averages them (a box filter). It draws the map's mesh
with the frame's camera, under the frame's directional light, without interreflections; `--bounces N` adds them. Pixels count that
the surface covers wholly in both pictures and that no shadow of the frame touches. Prints how many those are, the share of them whose red, green and
blue all differ by at most 5 % of the frame's values, and percentiles of the difference. Exit code 1 where the share is below 99 %.
`--pictures FOLDER` writes both pictures and eight times their difference.

Needs: pip install mitsuba numpy OpenEXR pillow; and LLVM's library of version 16 or later (Debian 12: apt-get install libllvm19)
"""

import argparse
import json
import math
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np
import OpenEXR

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))

WANTED = {
    "shading": "pixel",
    "samples": "1",
    "texels": "bilinear",
    "mip": "off",
    "parallax": "off",
    "weights": "continuous",
    "projection": "perspective",
}


def read_frame(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        header = dict(file.header())
        channels = {name: channel.pixels.astype(np.float64) for name, channel in file.channels().items()}
    options = json.loads(header["mesotex:options"])
    for name, value in WANTED.items():
        if str(options[name]) != value:
            raise SystemExit(f"{path}: rendered with --{name} {options[name]}; expected --{name} {value}")
    if "lightDirection" not in header:
        raise SystemExit(f"{path}: more lights than one, or none that is directional; expected one directional light")
    if "shadow.Y" not in channels:
        raise SystemExit(f"{path}: no layer of shadows; expected --layers rgba,shadow")
    return header, channels


def sensor(header, size, samples):
    """The frame's camera; matrices are for row vectors, the camera looks along its z, and the picture is 1 high."""
    camera_from_world = np.array(header["worldToCamera"], float).reshape(4, 4)
    camera = np.linalg.inv(camera_from_world)
    rows = abs((camera @ np.array(header["worldToNDC"], float).reshape(4, 4))[1, 1])
    position, ahead, up = camera[3, :3], camera[2, :3], camera[1, :3]
    to_world = mi.ScalarTransform4f().look_at(
        origin=position.tolist(), target=(position + ahead).tolist(), up=up.tolist()
    )
    distance = float(np.linalg.norm(position))
    return {
        "type": "perspective",
        "fov": math.degrees(2 * math.atan(0.5 / rows)),
        "fov_axis": "y",
        "near_clip": 1e-4 * distance,
        "far_clip": 1e4 * distance,
        "to_world": to_world,
        "sampler": {"type": "multijitter", "sample_count": samples},
        "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}, "pixel_format": "rgba"},
    }


def render(arguments, header, size):
    import mesotex.mitsuba

    light = -np.array(header["lightDirection"], float)
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2 + arguments.bounces, "hide_emitters": True},
        "sensor": sensor(header, size, arguments.samples),
        "surface": mesotex.mitsuba.shape(arguments.sample, arguments.map),
        "light": {"type": "directional", "direction": light.tolist(), "irradiance": float(header["lightIrradiance"])},
    }
    return np.array(mi.render(mi.load_dict(scene), seed=1)).astype(np.float64)


def reduced(pixels, side):
    """The mean of each block of side x side pixels."""
    height, width = (length // side for length in pixels.shape[:2])
    return pixels[: height * side, : width * side].reshape(height, side, width, side, -1).mean(axis=(1, 3))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sample")
    parser.add_argument("map")
    parser.add_argument("frame")
    parser.add_argument("--block", type=int, default=4, help="side of the blocks of the frame (default: 4)")
    parser.add_argument("--samples", type=int, default=64, help="rays per pixel (default: 64)")
    parser.add_argument("--bounces", type=int, default=0, help="reflections between parts of the surface (default: 0)")
    parser.add_argument("--pictures", type=Path, metavar="FOLDER")
    parser.add_argument("--variant", choices=("llvm_ad_rgb", "cuda_ad_rgb"), default="llvm_ad_rgb")
    arguments = parser.parse_args()
    mi.set_variant(arguments.variant)
    header, channels = read_frame(arguments.frame)
    ours = reduced(np.stack([channels[name] for name in ("R", "G", "B", "A", "shadow.Y")], -1), arguments.block)
    ours, reaches = ours[..., :4], ours[..., 4]
    theirs = render(arguments, header, ours.shape[1::-1])

    covered = (ours[..., 3] > 0.999) & (theirs[..., 3] > 0.999)
    alone = (ours[..., 3] > 0.5) != (theirs[..., 3] > 0.5)
    lit = covered & (reaches > 0.999)
    apart = np.abs(ours - theirs)[..., :3] / np.maximum(ours[..., :3], 1e-3)
    worst = apart.max(axis=-1)[lit]
    share = (worst <= 0.05).mean()
    print(f"{covered.sum()} pixels covered by both, {alone.sum()} mostly by one alone; {lit.sum()} of them without shadow")
    print(f"red, green and blue within 5 %: {100 * share:.3f} % (wanted 99 %)")
    print("difference: " + ", ".join(f"{p} % of pixels below {100 * np.percentile(worst, p):.2f} %" for p in (50, 95, 99, 99.9)))
    bias = ((theirs - ours)[..., :3][lit].mean() / ours[..., :3][lit].mean())
    print(f"mean: {100 * bias:+.3f} %")
    if arguments.pictures:
        save(arguments.pictures, ours[..., :3], theirs[..., :3])
    sys.exit(int(share < 0.99))


def save(folder, ours, theirs):
    from PIL import Image

    folder.mkdir(parents=True, exist_ok=True)
    pictures = {"ours": ours, "mitsuba": theirs, "difference": 8 * np.abs(ours - theirs)}
    for name, values in pictures.items():
        values = np.clip(values, 0, 1)
        curved = np.where(values <= 0.0031308, 12.92 * values, 1.055 * np.maximum(values, 0.0031308) ** (1 / 2.4) - 0.055)
        Image.fromarray(np.round(255 * curved).astype(np.uint8)).save(folder / f"{name}.png")


if __name__ == "__main__":
    main()
