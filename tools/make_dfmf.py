#!/usr/bin/env python3
"""Makes a synthetic DFMF file (Bonn .btf) of any size, to time imports and what follows.

Needs: pip install numpy
Run:   tools/make_dfmf.py -o large.btf --size 400 --components 100 --model 0

Eigentextures are smooth random textures of falling strength, and their factors smooth functions of view and light,
so that values are positive and components matter less and less, as in measured files. Views and lights are the 151 of
the UBO2014 dome. Model 0 holds RGB; model 11 holds ln(Y + 1e-5), U/(Y + 1e-5), V/(Y + 1e-5).
"""

import argparse
import struct

import numpy as np

RINGS = [(0, 1, 0), (11, 6, 15), (23.5, 12, 0), (30, 12, 15), (37.5, 12, 0), (45, 18, 0), (52.5, 18, 7.5),
         (60, 24, 0), (67.5, 24, 7.5), (75, 24, 0)]
TYPES = {2: np.float16, 4: np.float32, 8: np.float64}


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--size", type=int, default=400, help="texels along a side")
    parser.add_argument("--components", type=int, default=100)
    parser.add_argument("--model", type=int, choices=[0, 11], default=0)
    parser.add_argument("--scalar", type=int, choices=[2, 4, 8], default=2, help="bytes of a number")
    parser.add_argument("--rings", type=int, default=len(RINGS), help="take the first rings of the dome")
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args()


def dome(rings):
    """Polar and azimuth angles of the dome, in radians."""
    angles = [(theta, offset + 360 * i / count) for theta, count, offset in RINGS[:rings] for i in range(count)]
    return np.radians(np.array(angles))


def vectors(angles):
    theta, phi = angles.T
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], 1)


def textures(size, count, random):
    """Periodic textures of mean 0 and deviation 1, [texels, count]."""
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(size) * size, np.fft.rfftfreq(size) * size, indexing="ij"))
    columns = np.empty((size * size, count), np.float32)
    for column in range(count):
        spectrum = np.fft.rfft2(random.standard_normal((size, size)))
        center = 2.0 ** random.uniform(1, np.log2(max(size / 6, 2)))
        picture = np.fft.irfft2(spectrum * np.exp(-(frequency / center - 1) ** 2), (size, size))
        columns[:, column] = ((picture - picture.mean()) / picture.std()).ravel()
    return columns


def responses(views, lights, count, random):
    """Smooth functions of view and light between -1 and 1, [views * lights, count]."""
    rows = np.empty((len(views) * len(lights), count), np.float32)
    for column in range(count):
        a, b = random.standard_normal((2, 3)) * random.uniform(0.5, 3)
        phase = random.uniform(0, 2 * np.pi)
        rows[:, column] = np.sin((views @ a)[:, None] + (lights @ b)[None, :] + phase).ravel()
    return rows


def channel(kind, base, views, lights, size, components, random):
    """Factors of a channel: U and S V."""
    strength = 1 / (1 + np.arange(components)) ** 1.3
    u = responses(views, lights, components, random)
    sv = textures(size, components, random) * strength.astype(np.float32)
    cosine = np.broadcast_to(lights[:, 2], (len(views), len(lights))).ravel()
    if kind == "color":
        # The first component is the mean reflectance, the others modulate it; all of it falls with the cosine.
        u[:, 0], sv[:, 0] = 1, base
        sv[:, 1:] *= 0.12 * base
        u *= cosine[:, None]
    elif kind == "log":
        u[:, 0], sv[:, 0] = np.log(base * cosine + 1e-5), 1
        sv[:, 1:] *= 0.25
    else:
        u[:, 0], sv[:, 0] = 1, base
        sv[:, 1:] *= 0.03
    return u, sv


def text(string):
    return string.encode().ljust(80, b"\0")


def main():
    arguments = parse()
    random = np.random.default_rng(arguments.seed)
    angles = dome(arguments.rings)
    directions = vectors(angles)
    kinds = {0: [("color", 0.45), ("color", 0.3), ("color", 0.2)], 11: [("log", 0.3), ("ratio", -0.1), ("ratio", 0.15)]}
    names = [b"R", b"G", b"B"]
    meta = struct.pack("<I", 4) + text("synthetic") + text("") + text("") + struct.pack("<4f", 10, 1, 1, 1)
    meta += struct.pack("<2I", 1, 0) + struct.pack("<I", 3) + b"".join(struct.pack("<I", 1) + name for name in names)
    lights = struct.pack("<I", len(angles)) + angles.astype("<f4").tobytes()
    sampling = struct.pack("<I", len(angles)) + b"".join(view.astype("<f4").tobytes() + lights for view in angles)
    size, components = arguments.size, arguments.components
    number = np.dtype(TYPES[arguments.scalar]).newbyteorder("<")
    with open(arguments.output, "wb") as file:
        file.write(b"!DFMF08FCR" + struct.pack("<I", len(meta) + 4) + meta + sampling)
        file.write(struct.pack("<3I", size, size, 0))
        file.write(struct.pack("<Ii", components, arguments.model) + struct.pack("<12f", 0, 0, 0, *np.eye(3).ravel()))
        for kind, base in kinds[arguments.model]:
            u, sv = channel(kind, base, directions, directions, size, components, random)
            file.write(struct.pack("<B3I", arguments.scalar, components, len(u), len(sv)))
            for matrix in (np.sqrt((sv.astype(np.float64) ** 2).sum(0)), u, sv):
                file.write(matrix.astype(number).tobytes())


if __name__ == "__main__":
    main()
