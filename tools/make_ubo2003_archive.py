#!/usr/bin/env python3
"""Makes a zip archive of JPEG files as UBO2003 has them, from a made-up woven height field.

Needs: pip install numpy pillow
Run:   tools/make_ubo2003_archive.py -o weave.zip --size 256
       tools/measure_import.py weave.zip --mesotex target/release/mesotex

The 81 directions are those of the set: rings of 1, 6, 12, 18, 20 and 24 at 0, 15, 30, 45, 60 and 75 degrees.
Each of the 6561 images is lit by its light, with specular reflection and a little noise, so that it
compresses as photographs do. --rings 2 makes a smaller archive, of the first two rings.
"""

import argparse
import io
import math
import multiprocessing
import zipfile

import numpy as np
from PIL import Image

RINGS = [(0, 1), (15, 6), (30, 12), (45, 18), (60, 20), (75, 24)]


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--rings", type=int, default=len(RINGS))
    parser.add_argument("--quality", type=int, default=90)
    return parser.parse_args()


def directions(rings):
    """(theta, phi) in whole degrees."""
    return [(theta, 360 * k // count) for theta, count in RINGS[:rings] for k in range(count)]


def unit(theta, phi):
    theta, phi = math.radians(theta), math.radians(phi)
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


def surface(size):
    """Normals and colours of a weave."""
    y, x = np.mgrid[0:size, 0:size] * (2 * np.pi * 8 / size)
    over = np.sin(x) * np.sin(y) > 0
    height = np.where(over, np.abs(np.sin(x)), np.abs(np.sin(y))) + 0.1 * np.sin(5 * x) * np.sin(5 * y)
    dy, dx = np.gradient(height * 4)
    normals = np.stack([-dx, dy, np.ones_like(dx)], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    colors = np.where(over[..., None], [0.55, 0.3, 0.2], [0.2, 0.3, 0.5])
    return normals, colors


def image(task):
    """The name and the JPEG file of one image."""
    number, light, view, size, quality = task
    normals, colors = SURFACE
    to_light, to_view = unit(*light), unit(*view)
    half = (to_light + to_view) / np.linalg.norm(to_light + to_view)
    lit = np.clip(normals @ to_light, 0, None)[..., None]
    glossy = 0.3 * np.clip(normals @ half, 0, None)[..., None] ** 20
    noise = np.random.default_rng(number).normal(0, 0.01, (size, size, 1))
    linear = np.clip(lit * (colors + glossy) + noise, 0, 1)
    stored = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    file = io.BytesIO()
    Image.fromarray(np.round(stored * 255).astype(np.uint8)).save(file, "JPEG", quality=quality)
    (tl, pl), (tv, pv) = light, view
    name = f"WEAVE/tv{tv:03}_pv{pv:03}/{number:05} tl{tl:03} pl{pl:03} tv{tv:03} pv{pv:03}.jpg"
    return name, file.getvalue()


def main():
    global SURFACE
    arguments = parse()
    SURFACE = surface(arguments.size)
    every = directions(arguments.rings)
    tasks = [
        (len(every) * l + v, light, view, arguments.size, arguments.quality)
        for v, view in enumerate(every)
        for l, light in enumerate(every)
    ]
    with zipfile.ZipFile(arguments.output, "w", zipfile.ZIP_STORED) as archive:
        with multiprocessing.get_context("fork").Pool() as pool:
            for name, content in pool.imap(image, tasks, chunksize=16):
                archive.writestr(zipfile.ZipInfo(name), content)
    print(f"{arguments.output}: {len(tasks)} images")


if __name__ == "__main__":
    main()
