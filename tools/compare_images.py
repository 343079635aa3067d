#!/usr/bin/env python3
"""Compares how mesotex reads images with OpenImageIO and colour-science.

    pip install OpenImageIO==3.2.2.0 colour-science==0.4.7 tifffile==2026.3.3 pillow==13.0.0
    python3 tools/compare_images.py [--program target/release/mesotex]

Makes small images of many kinds in a temporary folder, imports each as a sample of one view and one
light (`mesotex import --values radiance --dtype f4`) and compares the linear Rec. 709 numbers. The
stored numbers come from OpenImageIO; curves, primaries and adaptation from colour-science. Prints a table
of the largest difference per variant, and ends with exit code 1 where one is beyond the format's precision.
"""

import argparse
import contextlib
import io
import struct
import subprocess
import sys
import tempfile
import warnings
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import tifffile
from PIL import Image

warnings.simplefilter("ignore")
with contextlib.redirect_stderr(io.StringIO()):
    import colour

WIDTH, HEIGHT = 40, 24
# The sRGB curve in single precision.
SINGLE = 3e-7
D65 = (0.3127, 0.3290)
SPACES = {
    "AP0": ("ACES2065-1", (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.0770, 0.32168, 0.33767)),
    "AP1": ("ACEScg", (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)),
    "Rec2020": ("ITU-R BT.2020", (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, *D65)),
    "P3": ("Display P3", (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, *D65)),
}
ADOBE = (0.64, 0.33, 0.21, 0.71, 0.15, 0.06, *D65)
RADIANCE = (0.640, 0.330, 0.290, 0.600, 0.150, 0.060, 0.3333, 0.3333)


def picture(channels=3):
    """A smooth picture with noise, 0 to 1."""
    random = np.random.default_rng(7)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    planes = [0.5 + 0.4 * np.sin(0.2 * x + c) * np.cos(0.3 * y + 2 * c) for c in range(channels)]
    noisy = np.stack(planes, -1) + 0.05 * random.random((HEIGHT, WIDTH, channels))
    return np.clip(noisy, 0.0, 1.0).astype(np.float32)


def smooth(channels=3):
    """A picture that JPEG and chroma subsampling keep."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    planes = [0.5 + 0.3 * np.sin(0.08 * x + 0.05 * y + c) for c in range(channels)]
    return np.stack(planes, -1).astype(np.float32)


# The reference's maths.

def srgb(stored):
    return colour.models.eotf_sRGB(np.asarray(stored, float))


def matrix(chromaticities):
    """Linear RGB of primaries and white to linear Rec. 709, Bradford adapted."""
    xy = np.asarray(chromaticities, float).reshape(4, 2)
    to_xyz = colour.normalised_primary_matrix(xy[:3], xy[3])
    whites = [colour.xy_to_XYZ(xy[3]), colour.xy_to_XYZ(D65)]
    adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(*whites, transform="Bradford")
    rec709 = colour.normalised_primary_matrix([0.64, 0.33, 0.30, 0.60, 0.15, 0.06], D65)
    return np.linalg.inv(rec709) @ adapt @ to_xyz


def converted(linear, chromaticities):
    """What mesotex imports of colours outside Rec. 709 is 0, hence the clip."""
    return np.maximum(linear @ matrix(chromaticities).T, 0.0)


def stored(path, subimage=0):
    """The numbers of a file as OpenImageIO has them, scaled to [0, 1] where integers."""
    buffer = oiio.ImageBuf(str(path), subimage, 0)
    if buffer.has_error:
        raise RuntimeError(buffer.geterror())
    return buffer.get_pixels(oiio.FLOAT)


# Writers.

def write(path, pixels, kind="float", names=None, **attributes):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    if names:
        spec.channelnames = names
    tile = attributes.pop("tile", None)
    if tile:
        spec.tile_width = spec.tile_height = tile
    window = attributes.pop("window", None)
    if window:
        spec.x, spec.y, spec.full_x, spec.full_y, spec.full_width, spec.full_height = window
    for name, value in attributes.items():
        name = name.replace("__", ":")
        if name == "chromaticities":
            spec.attribute(name, "float[8]", value)
        elif name == "ICCProfile":
            spec.attribute(name, f"uint8[{len(value)}]", np.frombuffer(value, np.uint8))
        else:
            spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    if not output or not output.open(str(path), spec):
        raise RuntimeError(oiio.geterror())
    ok = output.write_image(pixels)
    output.close()
    if not ok:
        raise RuntimeError(output.geterror())


def chunk(kind, content):
    checked = kind + content
    return struct.pack(">I", len(content)) + checked + struct.pack(">I", zlib.crc32(checked))


def packed(row, depth):
    """A row of integers, `depth` bits each."""
    if depth == 16:
        return row.astype(">u2").tobytes()
    if depth == 8:
        return row.astype(np.uint8).tobytes()
    bits = "".join(format(int(v), f"0{depth}b") for v in row)
    bits += "0" * (-len(bits) % 8)
    return bytes(int(bits[i:i + 8], 2) for i in range(0, len(bits), 8))


ADAM7 = [(0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1)]


def write_png(path, numbers, depth, color, chunks=(), interlaced=False):
    """PNG by hand: integers (height, width, channels)."""
    height, width, _ = numbers.shape
    passes = ADAM7 if interlaced else [(0, 0, 1, 1)]
    raw = b""
    for top, left, down, across in passes:
        for row in numbers[top::down, left::across]:
            if row.size:
                raw += b"\0" + packed(row.reshape(-1), depth)
    header = struct.pack(">IIBBBBB", width, height, depth, color, 0, 0, int(interlaced))
    parts = [chunk(b"IHDR", header), *[chunk(*c) for c in chunks]]
    parts += [chunk(b"IDAT", zlib.compress(raw)), chunk(b"IEND", b"")]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))


def s15(value):
    return struct.pack(">i", int(round(value * 65536)))


def icc(chromaticities=None, gamma=None, table=None):
    """A version 2 profile of matrix and curves, or of grey where there are no chromaticities."""
    if table is not None:
        curve = b"curv\0\0\0\0" + struct.pack(">I", len(table)) + np.asarray(table, ">u2").tobytes()
    else:
        curve = b"curv\0\0\0\0" + struct.pack(">IH", 1, int(round(gamma * 256)))
    curve += b"\0" * (-len(curve) % 4)
    xyz = lambda v: b"XYZ \0\0\0\0" + b"".join(map(s15, v))
    text = b"desc\0\0\0\0" + struct.pack(">I", 5) + b"test\0" + b"\0" * 79
    tags = [(b"desc", text), (b"wtpt", xyz((0.9642, 1.0, 0.8249)))]
    if chromaticities is None:
        space, tags = b"GRAY", tags + [(b"kTRC", curve)]
    else:
        xy = np.asarray(chromaticities, float).reshape(4, 2)
        whites = [colour.xy_to_XYZ(xy[3]), np.array([0.9642, 1.0, 0.8249])]
        adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(*whites, transform="Bradford")
        columns = (adapt @ colour.normalised_primary_matrix(xy[:3], xy[3])).T
        space = b"RGB "
        tags += [(name + b"XYZ", xyz(column)) for name, column in zip([b"r", b"g", b"b"], columns)]
        tags += [(name + b"TRC", curve) for name in [b"r", b"g", b"b"]]
    directory, body = b"", b""
    start = 128 + 4 + 12 * len(tags)
    for name, content in tags:
        directory += name + struct.pack(">II", start + len(body), len(content))
        body += content + b"\0" * (-len(content) % 4)
    length = start + len(body)
    header = struct.pack(">I", length) + b"lcms\x02\x40\0\0mntr" + space + b"XYZ " + b"\0" * 12
    header += b"acsp" + b"\0" * 28 + s15(0.9642) + s15(1.0) + s15(0.8249)
    return header.ljust(128, b"\0") + struct.pack(">I", len(tags)) + directory + body


def exif(orientation):
    return b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01" + struct.pack(">HHI", orientation, 0, 0)


def upright(pixels, orientation):
    turn = {1: lambda a: a, 2: lambda a: a[:, ::-1], 3: lambda a: a[::-1, ::-1], 4: lambda a: a[::-1],
            5: lambda a: a.transpose(1, 0, 2), 6: lambda a: a.transpose(1, 0, 2)[:, ::-1],
            7: lambda a: a.transpose(1, 0, 2)[::-1, ::-1], 8: lambda a: a.transpose(1, 0, 2)[::-1]}
    return turn[orientation](pixels)


def rgbe(pixels):
    """Mantissas and exponent of each pixel."""
    largest = pixels.max(-1)
    exponent = np.where(largest > 1e-32, np.frexp(largest)[1], -128)
    mantissas = np.floor(pixels * np.ldexp(1.0, 8 - exponent)[..., None]).clip(0, 255)
    return np.concatenate([mantissas, (exponent + 128)[..., None]], -1).astype(np.uint8)


def rgbe_values(stored_bytes):
    return stored_bytes[..., :3] * np.ldexp(1.0, stored_bytes[..., 3].astype(int) - 136)[..., None]


def write_hdr(path, stored_bytes, order="-Y +X", header="", form="rgbe", runs=None, magic="RADIANCE"):
    """Radiance by hand; `stored_bytes` (height, width, 4) as seen upright."""
    first, second = order.split()
    lines = stored_bytes if first[1] == "Y" else stored_bytes.transpose(1, 0, 2)
    flip = {"-Y": False, "+Y": True, "+X": False, "-X": True}
    lines = lines[::-1] if flip[first] else lines
    lines = lines[:, ::-1] if flip[second] else lines
    body = b""
    for line in lines:
        if runs == "new":
            body += struct.pack(">BBH", 2, 2, len(line))
            for component in line.T:
                at = 0
                while at < len(component):
                    run = 1
                    while at + run < len(component) and run < 127 and component[at + run] == component[at]:
                        run += 1
                    body += bytes([128 + run, component[at]]) if run > 1 else bytes([1, component[at]])
                    at += run
        elif runs == "old":
            at = 0
            while at < len(line):
                run = 1
                while at + run < len(line) and (line[at + run] == line[at]).all():
                    run += 1
                body += line[at].tobytes() + (bytes([1, 1, 1, run - 1]) if run > 1 else b"")
                at += run
        else:
            body += line.tobytes()
    text = f"#?{magic}\n{header}FORMAT=32-bit_rle_{form}\n\n"
    text += f"{first} {lines.shape[0]} {second} {lines.shape[1]}\n"
    path.write_bytes(text.encode() + body)


# Variants: name, path, expected linear numbers, tolerance.

def openexr(folder):
    pixels = picture()
    for kind in ("half", "float"):
        for packing in ("none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"):
            path = folder / f"{kind}_{packing}.exr"
            write(path, pixels, kind, compression=packing)
            yield f"EXR {kind} {packing}", path, stored(path), 0
    path = folder / "tiles.exr"
    write(path, pixels, "half", tile=16)
    yield "EXR tiles", path, stored(path), 0
    path = folder / "overscan.exr"
    write(path, pixels, window=(-3, -2, 0, 0, WIDTH - 8, HEIGHT - 6))
    yield "EXR overscan", path, stored(path)[2:2 + HEIGHT - 6, 3:3 + WIDTH - 8], 0
    path = folder / "shifted.exr"
    write(path, pixels, window=(100, -50, 100, -50, WIDTH, HEIGHT))
    yield "EXR window elsewhere", path, stored(path), 0
    for name, (_, chromaticities) in SPACES.items():
        path = folder / f"{name}.exr"
        write(path, pixels, chromaticities=chromaticities)
        yield f"EXR chromaticities {name}", path, converted(stored(path), chromaticities), 2e-6
    path = folder / "xyz.exr"
    third = 1 / 3
    xyz = (pixels @ colour.models.RGB_COLOURSPACE_BT709.matrix_RGB_to_XYZ.T).astype(np.float32)
    write(path, xyz, chromaticities=(1, 0, 0, 1, 0, 0, third, third))
    yield "EXR tristimulus", path, colour.XYZ_to_RGB(stored(path), colour.models.RGB_COLOURSPACE_BT709), 2e-6
    path = folder / "interop.exr"
    write(path, pixels, colorInteropID="lin_ap1_scene")
    yield "EXR colorInteropID", path, converted(stored(path), SPACES["AP1"][1]), 2e-6
    path = folder / "layers.exr"
    both = np.concatenate([picture(1) * 5, pixels], -1)
    write(path, both, names=("depth.Z", "view.diffuse.R", "view.diffuse.G", "view.diffuse.B"))
    yield "EXR one colour layer", path, pixels, 0
    path = folder / "grey.exr"
    write(path, picture(1), names=("Y",))
    yield "EXR luminance", path, stored(path), 0
    path = folder / "opaque.exr"
    write(path, np.concatenate([pixels, np.ones((HEIGHT, WIDTH, 1), np.float32)], -1))
    yield "EXR opaque alpha", path, pixels, 0


def png(folder):
    pixels = picture()
    rgb8, rgb16 = np.round(pixels * 255), np.round(pixels * 65535)
    grey = picture(1)
    plain = lambda path: srgb(stored(path))
    for depth in (1, 2, 4, 8, 16):
        path = folder / f"grey{depth}.png"
        numbers = np.round(grey * (2**depth - 1))
        write_png(path, numbers, depth, 0)
        yield f"PNG grey {depth} bits", path, srgb(numbers / (2**depth - 1)), SINGLE
    for name, numbers, depth in (("8", rgb8, 8), ("16", rgb16, 16)):
        for interlaced in (False, True):
            path = folder / f"rgb{name}{interlaced}.png"
            write_png(path, numbers, depth, 2, interlaced=interlaced)
            yield f"PNG RGB {name} bits{', interlaced' if interlaced else ''}", path, plain(path), SINGLE
    for depth in (1, 2, 4, 8):
        path = folder / f"palette{depth}.png"
        entries = np.random.default_rng(1).integers(0, 256, (2**depth, 3), np.uint8)
        index = np.round(grey * (2**depth - 1)).astype(int)
        write_png(path, index, depth, 3, [(b"PLTE", entries.tobytes())])
        yield f"PNG palette {depth} bits", path, srgb(entries[index[..., 0]] / 255.0), SINGLE
    path = folder / "rgba.png"
    write_png(path, np.concatenate([rgb8, np.full((HEIGHT, WIDTH, 1), 255)], -1), 8, 6)
    yield "PNG opaque alpha", path, srgb(rgb8 / 255), SINGLE
    chrm = lambda c: (b"cHRM", struct.pack(">8I", *[int(round(v * 1e5)) for v in (*c[6:], *c[:6])]))
    linear = rgb16 / 65535
    for gamma in (1.0, 0.55, 0.45455):
        path = folder / f"gama{gamma}.png"
        write_png(path, rgb16, 16, 2, [(b"gAMA", struct.pack(">I", int(round(gamma * 1e5))))])
        yield f"PNG gAMA {gamma}", path, linear ** (1 / gamma), 1e-6
    path = folder / "chrm.png"
    write_png(path, rgb16, 16, 2, [(b"gAMA", struct.pack(">I", 45455)), chrm(ADOBE)])
    yield "PNG gAMA and cHRM", path, converted(linear ** 2.2, ADOBE), 1e-5
    path = folder / "srgb.png"
    write_png(path, rgb16, 16, 2, [(b"sRGB", b"\0"), (b"gAMA", struct.pack(">I", 100000)), chrm(ADOBE)])
    yield "PNG sRGB before gAMA", path, srgb(linear), SINGLE
    profile = (b"iCCP", b"test\0\0" + zlib.compress(icc(ADOBE, 563 / 256)))
    adobe = converted(linear ** (563 / 256), ADOBE)
    path = folder / "iccp.png"
    write_png(path, rgb16, 16, 2, [profile, (b"gAMA", struct.pack(">I", 100000))])
    yield "PNG iCCP Adobe before gAMA", path, adobe, 3e-5
    path = folder / "greyicc.png"
    write_png(path, np.round(grey * 65535), 16, 0, [(b"iCCP", b"g\0\0" + zlib.compress(icc(None, 1.8)))])
    gamma = int(round(1.8 * 256)) / 256
    yield "PNG iCCP grey", path, (np.round(grey * 65535) / 65535) ** gamma, 3e-5
    path = folder / "cicp.png"
    write_png(path, rgb16, 16, 2, [(b"cICP", bytes([12, 13, 0, 1])), profile])
    yield "PNG cICP P3 before iCCP", path, converted(srgb(linear), SPACES["P3"][1]), 2e-6
    path = folder / "cicp9.png"
    write_png(path, rgb16, 16, 2, [(b"cICP", bytes([9, 14, 0, 1]))])
    bt2020 = colour.models.oetf_inverse_BT2020(linear, is_12_bits_system=True)
    yield "PNG cICP BT.2020", path, converted(bt2020, SPACES["Rec2020"][1]), 2e-5
    for orientation in range(2, 9):
        path = folder / f"exif{orientation}.png"
        write_png(path, rgb8, 8, 2, [(b"eXIf", exif(orientation))])
        yield f"PNG orientation {orientation}", path, upright(srgb(rgb8 / 255), orientation), SINGLE


def tiff(folder):
    pixels, grey = picture(), picture(1)
    for kind, tolerance in (("uint8", SINGLE), ("uint16", SINGLE), ("half", 0), ("float", 0), ("double", 1e-7)):
        for name, options in (
            ("", {}),
            (" planes", {"planarconfig": "separate"}),
            (" tiles", {"tile": 16}),
            (" LZW", {"compression": "lzw"}),
            (" deflate", {"compression": "zip"}),
        ):
            path = folder / f"{kind}{name.strip()}.tif"
            write(path, pixels, kind, **options)
            # OpenImageIO reads tiles of doubles back as NaN.
            numbers = pixels if kind == "double" else stored(path)
            yield f"TIFF {kind}{name}", path, srgb(numbers) if "int" in kind else numbers, tolerance
    path = folder / "packbits.tif"
    write(path, pixels, "uint8", compression="packbits")
    yield "TIFF PackBits", path, srgb(stored(path)), SINGLE
    for big in (False, True):
        for order in "<>":
            path = folder / f"big{big}{ord(order)}.tif"
            numbers = np.round(pixels * 65535).astype(np.uint16)
            tifffile.imwrite(path, numbers, photometric="rgb", bigtiff=big, byteorder=order)
            name = f"TIFF {'Big' if big else ''}{'II' if order == '<' else 'MM'}"
            yield name, path, srgb(stored(path)), SINGLE
    for depth, dtype in ((8, np.uint8), (16, np.uint16)):
        path = folder / f"white{depth}.tif"
        tifffile.imwrite(path, np.round(grey[..., 0] * (2**depth - 1)).astype(dtype), photometric="miniswhite")
        flat = 1 - np.round(grey * (2**depth - 1)) / (2**depth - 1)
        yield f"TIFF min is white {depth} bits", path, srgb(flat), SINGLE
    path = folder / "palette.tif"
    entries = np.random.default_rng(1).integers(0, 65536, (3, 256)).astype(np.uint16)
    index = np.round(grey[..., 0] * 255).astype(np.uint8)
    tifffile.imwrite(path, index, photometric="palette", colormap=entries)
    yield "TIFF palette", path, srgb(entries.T[index] / 65535), SINGLE
    path = folder / "bits.tif"
    bits = grey[..., 0] > 0.5
    Image.fromarray(bits).save(path)
    yield "TIFF 1 bit", path, bits[..., None].astype(float), SINGLE
    path = folder / "opaque.tif"
    write(path, np.concatenate([pixels, np.ones((HEIGHT, WIDTH, 1), np.float32)], -1), "uint16")
    yield "TIFF opaque alpha", path, srgb(stored(path)[..., :3]), SINGLE
    path = folder / "icc.tif"
    write(path, pixels, "uint16", ICCProfile=icc(ADOBE, 563 / 256))
    yield "TIFF ICC Adobe", path, converted(stored(path) ** (563 / 256), ADOBE), 3e-5
    table = np.round(65535 * np.linspace(0, 1, 1024) ** 1.8)
    path = folder / "table.tif"
    write(path, pixels, "uint16", ICCProfile=icc(SPACES["P3"][1], table=table))
    curve = np.interp(stored(path), np.linspace(0, 1, 1024), table / 65535)
    yield "TIFF ICC of tables", path, converted(curve, SPACES["P3"][1]), 3e-5
    for orientation in range(2, 9):
        path = folder / f"turned{orientation}.tif"
        write(path, pixels, "uint8", Orientation=orientation)
        yield f"TIFF orientation {orientation}", path, upright(srgb(stored(path)), orientation), SINGLE


def hdr(folder):
    pixels = picture() * np.array([4.0, 0.5, 20.0])
    pixels[5:9, 3:30] = pixels[5, 3]
    stored_bytes = rgbe(pixels)
    values = rgbe_values(stored_bytes)
    path = folder / "oiio.hdr"
    write(path, pixels.astype(np.float32))
    yield "HDR of OpenImageIO", path, stored(path), 0
    for order in ("-Y +X", "-Y -X", "+Y +X", "+Y -X", "+X -Y", "+X +Y", "-X -Y", "-X +Y"):
        path = folder / f"order{order}.hdr"
        write_hdr(path, stored_bytes, order)
        yield f"HDR order {order}", path, values, 0
    for runs in ("old", "new"):
        path = folder / f"runs_{runs}.hdr"
        write_hdr(path, stored_bytes, runs=runs, magic="RGBE")
        yield f"HDR {runs} run lengths, #?RGBE", path, values, 0
    path = folder / "exposure.hdr"
    write_hdr(path, stored_bytes, header="EXPOSURE=2.5\nEXPOSURE=2\nCOLORCORR=1 2 0.5\n")
    yield "HDR EXPOSURE, COLORCORR", path, values / 5 / np.array([1, 2, 0.5]), 1e-6
    path = folder / "primaries.hdr"
    write_hdr(path, stored_bytes, header="PRIMARIES=" + " ".join(map(str, RADIANCE)) + "\n")
    yield "HDR PRIMARIES", path, converted(values, RADIANCE), 2e-5
    path = folder / "xyze.hdr"
    write_hdr(path, stored_bytes, form="xyze")
    third = 1 / 3
    e = np.array([third, third])
    bt709 = colour.models.RGB_COLOURSPACE_BT709
    yield "HDR XYZE", path, np.maximum(colour.XYZ_to_RGB(values, bt709, e, "Bradford"), 0), 2e-6


def jpeg(folder):
    pixels = np.round(smooth() * 255).astype(np.uint8)
    # Two levels of 8 bits: decoders round the cosine transform differently.
    close = 2.2 / 255 * 2
    for name, options in (
        ("4:4:4", {"subsampling": 0}),
        ("4:2:0", {"subsampling": 2}),
        ("progressive", {"subsampling": 0, "progressive": True}),
    ):
        path = folder / f"{name.replace(':', '')}.jpg"
        Image.fromarray(pixels).save(path, quality=97, **options)
        # Chroma of half resolution is also interpolated differently.
        yield f"JPEG {name}", path, srgb(stored(path)), close * (1.5 if name == "4:2:0" else 1)
    path = folder / "grey.jpg"
    Image.fromarray(pixels[..., 0]).save(path, quality=97)
    yield "JPEG grey", path, srgb(stored(path)), close
    path = folder / "icc.jpg"
    Image.fromarray(pixels).save(path, quality=97, subsampling=0, icc_profile=icc(ADOBE, 563 / 256))
    yield "JPEG ICC Adobe", path, converted(stored(path) ** (563 / 256), ADOBE), 2 * close
    for orientation in range(2, 9):
        path = folder / f"exif{orientation}.jpg"
        data = b"Exif\0\0" + exif(orientation)
        Image.fromarray(pixels).save(path, quality=97, subsampling=0, exif=data)
        yield f"JPEG orientation {orientation}", path, upright(srgb(stored(path)), orientation), close


def imported(program, path, folder):
    """The linear numbers that mesotex has of a file, or its error."""
    table = folder / "angles.csv"
    names = "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg"
    table.write_text(f"{names}\n{path},0,0,0,0\n")
    sample = folder / "one.sample"
    options = ["--values", "radiance", "--dtype", "f4", "--orientation", "upright"]
    command = [program, "import", str(table), "-o", str(sample), *options]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        return run.stderr.strip().splitlines()[0]
    return np.load(sample / "radiance.npy")[0, 0]


def difference(found, expected):
    """The largest difference, relative where numbers are above 1."""
    expected = np.asarray(expected, float)
    if expected.shape[-1] == 1:
        expected = np.repeat(expected, 3, -1)
    if found.shape != expected.shape:
        return np.inf
    return float(np.max(np.abs(found - expected) / np.maximum(1.0, np.abs(expected))))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="target/release/mesotex")
    program = parser.parse_args().program
    failed = count = 0
    print(f"{'variant':36} {'difference':>11} {'allowed':>9}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind in (openexr, png, tiff, hdr, jpeg):
            inner = folder / kind.__name__
            inner.mkdir()
            for variant, path, expected, allowed in kind(inner):
                found = imported(program, path, folder)
                count += 1
                if isinstance(found, str):
                    failed += 1
                    print(f"{variant:36} {found}")
                    continue
                off = difference(found, expected)
                bad = not off <= allowed
                failed += bad
                print(f"{variant:36} {off:11.2e} {allowed:9.0e}{'  too much' if bad else ''}")
    print(f"{count} variants, {failed} beyond the format's precision")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
