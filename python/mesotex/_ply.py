"""The PLY files that mesotex writes: binary, little-endian, triangles alone."""

import numpy as np

from mesotex._errors import DataError, check

_TYPES = {
    "float": "<f4",
    "double": "<f8",
    "uchar": "u1",
    "char": "i1",
    "ushort": "<u2",
    "short": "<i2",
    "uint": "<u4",
    "int": "<i4",
}


def read_ply(path):
    """The comments of a file, as a dict from the first word to the rest, and its vertices and faces, structured."""
    with open(path, "rb") as file:
        comments, elements = _read_header(path, file)
        tables = {}
        for name, count, fields in elements:
            kind = np.dtype(fields)
            data = file.read(count * kind.itemsize)
            expected = f"{count} of {kind.itemsize} bytes"
            check(len(data) == count * kind.itemsize, path, name, f"{len(data)} bytes", expected)
            tables[name] = np.frombuffer(data, kind)
    for name in ("vertex", "face"):
        check(name in tables, path, "elements", list(tables), "vertex and face")
    faces = tables["face"]
    are_triangles = len(faces) == 0 or bool((faces["corners"] == 3).all())
    check(are_triangles, path, "face", "polygons of other sides", "triangles")
    return comments, tables["vertex"], faces


def _read_header(path, file):
    check(file.readline().strip() == b"ply", path, "first line", "no `ply`", "a PLY file")
    comments, elements = {}, []
    for line in iter(file.readline, b""):
        words = line.decode("utf-8", "replace").split()
        if words == ["end_header"]:
            return comments, elements
        if words[:1] == ["format"]:
            check(words[1] == "binary_little_endian", path, "format", words[1], "binary_little_endian")
        elif words[:1] == ["comment"] and len(words) > 1:
            comments[words[1]] = words[2:]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:2] == ["property", "list"]:
            check(words[2:4] == ["uchar", "int"], path, "list", words[2:4], "list uchar int")
            elements[-1][2].extend([("corners", "u1"), (words[4], "<i4", (3,))])
        elif words[:1] == ["property"]:
            check(words[1] in _TYPES, path, "property", words[1], f"one of {sorted(_TYPES)}")
            elements[-1][2].append((words[2], _TYPES[words[1]]))
    raise DataError(path, "header", "the end of the file", "end_header")


def columns(table, names, kind=np.float32):
    """Some columns of a table side by side, [count, names]."""
    return np.stack([table[name].astype(kind) for name in names], axis=1)
