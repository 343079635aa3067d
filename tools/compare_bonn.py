#!/usr/bin/env python3
"""Decodes a Bonn .btf file with NumPy and compares it with a sample of whole images.

Needs: pip install numpy
Run:   tools/compare_bonn.py weave.btf weave-whole.sample

The file is read as btflib lays it out, whole, into memory: DFMF of colour models 0, 1, 3 and 4, FMF, PVF and BDI with or
without a mask, not packed. Values are reflectance with the light's cosine, over pi; negative ones are 0. Prints the
largest difference and the relative error; fails above --most.
"""

import argparse
import json
import os
import struct
import sys

import numpy as np

TYPES = {2: "<f2", 4: "<f4", 8: "<f8"}
TO_RGB = {0: np.eye(3), 1: np.array([[1, 0, 1.13983], [1, -0.39465, -0.5806], [1, 2.03211, 0]]),
          4: np.array([[1, 1, -1], [1, 0, 1], [1, -1, -1]])}
SIGNATURES = [b"!DFMF08FCR", b"!FMF12FCER", b"!FMF06FCR", b"!FMF06FC", b"!PVF06FCR", b"!PVF06FC", b"!BDIF06R2!"]


class File:
    def __init__(self, path):
        with open(path, "rb") as file:
            self.bytes, self.at = file.read(), 0

    def take(self, form):
        numbers = struct.unpack_from("<" + form, self.bytes, self.at)
        self.at += struct.calcsize("<" + form)
        return numbers if len(numbers) > 1 else numbers[0]

    def skip(self, count):
        self.at += count

    def array(self, kind, *sides):
        count = int(np.prod(sides))
        numbers = np.frombuffer(self.bytes, kind, count, self.at).reshape(sides)
        self.at += count * np.dtype(kind).itemsize
        return numbers.astype(np.float64)


def header(file, signature):
    """Whether the cosine is in the values, the number of channels, angles of views and lights."""
    file.at = len(signature)
    start, (size, version) = file.at, file.take("2I")
    file.skip(240 + 16)
    cosine = file.take("I") if version > 1 else 0
    if version > 2:
        file.skip(file.take("I"))
    channels = file.take("I") if version > 3 else 3
    for _ in range(channels if version > 3 else 0):
        file.skip(file.take("I"))
    assert file.at - start == size
    views, lights = [], None
    for _ in range(file.take("I")):
        views.append(file.take("2f"))
        lights = file.array("<f4", file.take("I"), 2)
    return cosine, channels, np.array(views), lights


def rotations(file):
    count = file.take("I")
    assert count == 0, "rotations are not decoded here"


def matrices(file, scalar):
    components, rows, columns = file.take("3I")
    file.array(TYPES[scalar], components)
    return file.array(TYPES[scalar], rows, components), file.array(TYPES[scalar], columns, components)


def dfmf(file, images, texels):
    model = file.take("Ii")[1]
    mean, matrix = file.array("<f4", 3), file.array("<f4", 3, 3)
    channels = []
    for _ in range(3):
        u, v = matrices(file, file.take("B"))
        channels.append(u @ v.T if len(u) == images else v @ u.T)
    values = np.stack(channels, -1)
    return values @ matrix + mean if model == 3 else values @ TO_RGB[model].T


def fmf(file, images, texels, extra):
    version, reduced = (file.take("B"), 0) if extra else (0, 0)
    if version >= 1:
        reduced = file.take("I")
    if version >= 2:
        file.skip(2 * int(np.prod(file.take("2I"))))
    file.take("I")
    u, v = matrices(file, file.take("B"))
    if len(u) == images * 3:
        values = (u @ v.T).reshape(images, 3, texels).transpose(0, 2, 1)
    else:
        values = (v @ u.T).reshape(images, texels, 3)
    return np.exp(values) - 1e-5 if reduced else values


def pvf(file, views, lights, texels):
    assert file.take("2I")[1] == views
    values = []
    for _ in range(views):
        kind = TYPES[file.take("B")]
        components, rows, dimension = file.take("3I")
        file.array(kind, components)
        mean, c = file.array(kind, dimension), file.array(kind, dimension, components)
        w = file.array(kind, rows, components)
        if dimension == 3 * lights:
            values.append((mean[:, None] + c @ w.T).reshape(lights, 3, texels).transpose(0, 2, 1))
        else:
            values.append((mean + w @ c.T).reshape(lights, texels, 3))
    return np.concatenate(values)


def bdi(file, images, width, height):
    lines, compression = file.take("IB")
    assert compression in (0, 2), "packed chunks are not decoded here"
    mask = file.array("u1", width, height).T.ravel() != 0
    rotations(file)
    stored = np.flatnonzero(mask) if compression == 2 else np.arange(width * height)
    values = np.zeros((width * height, images, 3))
    for first in range(0, len(stored), lines * width):
        texels = stored[first:first + lines * width]
        end = file.take("I") + file.at
        values[texels] = file.array("<f2", len(texels), images, 3)
        file.at = end
    return values.transpose(1, 0, 2)


def decode(path):
    """Values [views, lights, height, width, 3] as a sample has them."""
    file = File(path)
    signature = max((s for s in SIGNATURES if file.bytes.startswith(s)), key=len)
    cosine, channels, views, lights = header(file, signature)
    assert channels == 3
    width, height = file.take("2I")
    images, texels = len(views) * len(lights), width * height
    if signature.startswith(b"!BDI"):
        values = bdi(file, images, width, height)
    else:
        if signature.endswith(b"R"):
            rotations(file)
        if signature.startswith(b"!DFMF"):
            values = dfmf(file, images, texels)
        elif signature.startswith(b"!FMF"):
            values = fmf(file, images, texels, b"FCE" in signature)
        else:
            values = pvf(file, len(views), len(lights), texels)
    assert file.at == len(file.bytes), "numbers are left"
    values = np.maximum(values, 0).reshape(len(views), len(lights), height, width, 3) / np.pi
    return values if cosine else values * np.cos(lights[:, 0])[:, None, None, None]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("btf")
    parser.add_argument("sample")
    parser.add_argument("--most", type=float, default=1e-3, help="the largest relative error that passes")
    arguments = parser.parse_args()
    with open(os.path.join(arguments.sample, "btf.json")) as file:
        layout = json.load(file)["layout"]
    assert layout == "product", "import the file with --expand"
    wanted = np.load(os.path.join(arguments.sample, "radiance.npy")).astype(np.float64)
    found = decode(arguments.btf)
    relative = np.linalg.norm(found - wanted) / np.linalg.norm(wanted)
    print(f"largest difference {np.abs(found - wanted).max():.2e}, relative error {relative:.2e}")
    sys.exit(int(relative > arguments.most))


if __name__ == "__main__":
    main()
