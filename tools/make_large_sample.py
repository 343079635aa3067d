#!/usr/bin/env python3
"""Makes a sample of any size from a small one, to try what a machine's memory holds.

Needs: pip install numpy blake3 (without blake3 the sample has the small one's id).
Run:   tools/make_large_sample.py weave.sample -o large.sample --size 256 --images 20800

Every image is one of the small sample's, repeated to size x size texels and multiplied by smooth
random bumps, so that texels and images differ. The lights are spread over the hemisphere; one view.
"""

import argparse
import json
import os

import numpy as np


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sample")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--images", type=int, default=20800)
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args()


def lights(count):
    """A Fibonacci spiral over the upper hemisphere."""
    i = np.arange(count)
    z = 1 - (i + 0.5) / count
    phi = i * np.pi * (3 - 5 ** 0.5)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], 1).tolist()


def bumps(size, random, count=64):
    """Periodic pictures of a few waves, around 1, [count, size, size]."""
    at = np.arange(size) * 2 * np.pi / size
    pictures = np.ones((count, size, size), np.float32)
    for picture in pictures:
        for ky, kx, phase in random.integers(1, 9, (6, 3)):
            picture += 0.05 * np.sin(ky * at + phase)[:, None] * np.cos(kx * at + phase)
    return pictures


def main():
    arguments = parse()
    with open(os.path.join(arguments.sample, "btf.json")) as file:
        description = json.load(file)
    height, width = description["height"], description["width"]
    small = np.load(os.path.join(arguments.sample, "radiance.npy"), mmap_mode="r").reshape(-1, height, width, 3)
    size, count = arguments.size, arguments.images
    repeats = (-(-size // height), -(-size // width), 1)
    random = np.random.default_rng(arguments.seed)
    factors = bumps(size, random)
    os.makedirs(arguments.output, exist_ok=True)
    path = os.path.join(arguments.output, "radiance.npy")
    large = np.lib.format.open_memmap(path, "w+", np.float16, (1, count, size, size, 3))
    for image in range(count):
        tiled = np.tile(small[image % len(small)], repeats)[:size, :size].astype(np.float32)
        large[0, image] = tiled * factors[random.integers(len(factors))][..., None]
    large.flush()
    try:
        from blake3 import blake3
        description["id"] = blake3(max_threads=blake3.AUTO).update_mmap(path).hexdigest()[:32]
    except ImportError:
        pass
    description.update(name="large", width=size, height=size, dtype="f2", layout="product",
                       views=[[0.0, 0.0, 1.0]], lights=lights(count), source={"made-by": "make_large_sample.py"})
    description.pop("pairs", None)
    with open(os.path.join(arguments.output, "btf.json"), "w") as file:
        json.dump(description, file)


if __name__ == "__main__":
    main()
