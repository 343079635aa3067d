#!/usr/bin/env python3
"""Holds the error of a factored sample against NumPy's exact truncated singular value decomposition.

    python3 compare_factors.py WHOLE.sample FACTORED.sample

WHOLE.sample is what FACTORED.sample was made from by `mesotex factor`. Prints the error that the factors leave,
the least that any factors of that rank leave per channel, and their ratio; exit code 1 where the
ratio is above 1.05. Needs numpy, and memory for the sample in 64-bit floats, a channel at a time.
"""

import json
import pathlib
import sys

import numpy as np

LARGEST_RATIO = 1.05


def images_of(folder):
    """The values of a sample stored whole, [images, texels, 3]."""
    description = json.loads((folder / "btf.json").read_text())
    radiance = np.load(folder / "radiance.npy", mmap_mode="r")
    texels = description["height"] * description["width"]
    return radiance.reshape(-1, texels, 3)


def products_of(folder):
    """The values of a factored sample as they are read, channel by channel, and its rank."""
    description = json.loads((folder / "btf.json").read_text())
    directions = np.load(folder / "directions.npy").astype(np.float64)
    eigentextures = np.load(folder / "eigentextures.npy").astype(np.float64)
    transform = np.reshape(description.get("color_transform", np.eye(3)), (3, 3))
    mean = description.get("color_mean", [0, 0, 0])
    if not np.array_equal(transform, np.eye(3)) or np.any(mean):
        sys.exit("the factors are not of R, G and B")

    def channel(at):
        product = directions[at] @ eigentextures[min(at, len(eigentextures) - 1)].T
        return np.maximum(product, 0)

    return channel, description["rank"]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    whole, factored = (pathlib.Path(name) for name in sys.argv[1:])
    images = images_of(whole)
    product, rank = products_of(factored)
    total = left = least = 0.0
    for channel in range(3):
        values = np.asarray(images[:, :, channel], dtype=np.float64)
        total += np.sum(values**2)
        left += np.sum((values - product(channel)) ** 2)
        # The squared singular values are the eigenvalues of the smaller product with itself.
        gram = values @ values.T if len(values) < values.shape[1] else values.T @ values
        energies = np.linalg.eigvalsh(gram)[::-1]
        least += np.sum(np.maximum(energies[rank:], 0))
    error, exact = np.sqrt(left / total), np.sqrt(least / total)
    ratio = error / exact if exact > 0 else 1.0
    print(f"rank {rank}: error {error:.6f}, exact decomposition {exact:.6f}, ratio {ratio:.4f}")
    sys.exit(int(ratio > LARGEST_RATIO))


if __name__ == "__main__":
    main()
