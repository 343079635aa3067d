"""What the fetch_*.py scripts share: their options, downloads that resume and are checked, and the conversion.

A download goes to FILE.part. When it is cut off, the same command goes on after the last byte, if the server
still has the same file; else it begins anew. FILE appears when its size and, where one is given, its SHA-256 are
right. Nothing is fetched that is there already.

Needs nothing but Python 3.8 or later.
"""

import argparse
import hashlib
import shlex
import subprocess
import sys
import urllib.error
import urllib.request
import zipfile
from pathlib import Path
from urllib.parse import unquote, urlsplit

PIECE = 1 << 20
SECONDS = 60
# Bytes per byte of an archive; pictures are hardly ever packed to less than a hundredth.
MOST_BYTES = 256


def options_of(description, terms, page, address=None):
    """A parser with the options of all scripts; `address` is the pattern they fetch from, where one is known."""
    known = f"default: {address}" if address else f"none is known for sure; find it on {page}"
    parser = argparse.ArgumentParser(
        description=description.strip().splitlines()[0],
        epilog=f"{terms} Page of the data: {page}",
    )
    parser.add_argument("--address", required=address is None, help=f"where the file is ({known})")
    parser.add_argument("--into", type=Path, default=Path("."), help="folder for the file and the sample")
    parser.add_argument("--size", type=int, help="refuse another number of bytes")
    parser.add_argument("--sha256", help="refuse a file of another SHA-256")
    parser.add_argument("--only-fetch", action="store_true", help="fetch and check, do not convert")
    parser.add_argument("--mesotex", default="mesotex", help="the program that converts, default mesotex")
    parser.add_argument(
        "--import-options", default="", help='further options of `mesotex import`, as "--texel-mm 0.2"'
    )
    return parser


def fetch_archive(description, terms, page, name_help="what to call the sample"):
    """A whole script for sets that are archives whose address the user gives."""
    parser = options_of(description, terms, page)
    parser.add_argument("name", help=name_help)
    options = parser.parse_args()
    print(terms, page)
    archive = fetch(options.address, options.into, options.size, options.sha256)
    convert(options, archive, options.into / f"{options.name.lower()}.sample")


def name_of(address):
    """The file's name at the end of an address."""
    name = unquote(urlsplit(address).path).rsplit("/", 1)[-1].replace("\\", "_")
    if name in ("", ".", ".."):
        sys.exit(f"{address}: no file's name at its end")
    return name


def fetch(address, folder, size=None, sha256=None):
    """Fetches a file into a folder, or finds it there; hands back its path."""
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / name_of(address)
    if target.exists():
        check(target, target, size, sha256)
        print(f"{target}: there already")
        return target
    part = folder / (target.name + ".part")
    try:
        download(address, part, size)
    except (urllib.error.URLError, OSError) as error:
        kept = f"; {part} is kept, the same command goes on with it" if part.exists() else ""
        sys.exit(f"{address}: {error}{kept}")
    check(part, target, size, sha256)
    part.replace(target)
    tag_of(part).unlink(missing_ok=True)
    print(f"{target}: {target.stat().st_size} bytes")
    return target


def tag_of(part):
    """Where it is noted which version of a file was begun."""
    return part.with_name(part.name + ".version")


def download(address, part, size):
    have = part.stat().st_size if part.exists() else 0
    tag = tag_of(part).read_text() if tag_of(part).exists() else ""
    headers = {"User-Agent": "mesotex"}
    if have and tag:
        headers.update({"Range": f"bytes={have}-", "If-Range": tag})
    request = urllib.request.Request(address, headers=headers)
    try:
        answer = urllib.request.urlopen(request, timeout=SECONDS)
    except urllib.error.HTTPError as error:
        # Nothing is left to fetch: the size and the hash decide whether it is the file.
        if error.code == 416 and have:
            return
        raise
    with answer:
        resumes = answer.status == 206
        begun = have if resumes else 0
        length = answer.headers.get("Content-Length")
        total = begun + int(length) if length else None
        if size is not None and total is not None and total != size:
            sys.exit(f"{address}: the server has {total} bytes; expected {size}")
        tag_of(part).write_text(answer.headers.get("ETag") or answer.headers.get("Last-Modified") or "")
        with open(part, "ab" if resumes else "wb") as out:
            copy(answer, out, begun, total, part)
    got = part.stat().st_size
    if total is not None and got != total:
        raise OSError(f"cut off after {got} of {total} bytes")


def copy(answer, out, done, total, part):
    """Copies what the server sends, and tells on a terminal how far it is."""
    while True:
        piece = answer.read(PIECE)
        if not piece:
            break
        out.write(piece)
        done += len(piece)
        if sys.stderr.isatty():
            of = f" of {total / 1e6:.1f}" if total else ""
            print(f"\r{part.name}: {done / 1e6:.1f}{of} MB", end="", file=sys.stderr)
    if sys.stderr.isatty():
        print(file=sys.stderr)


def check(path, target, size, sha256):
    """Refuses a file of another size or hash; an unfinished download of one is removed."""
    found = None
    if size is not None and path.stat().st_size != size:
        found = f"{path.stat().st_size} bytes; expected {size}"
    elif sha256 is not None:
        digest = hashlib.sha256()
        with open(path, "rb") as file:
            while piece := file.read(PIECE):
                digest.update(piece)
        if digest.hexdigest() != sha256.lower():
            found = f"SHA-256 {digest.hexdigest()}; expected {sha256.lower()}"
    if found is None:
        return
    if path != target:
        path.unlink()
        tag_of(path).unlink(missing_ok=True)
    sys.exit(f"{target}: {found}")


def unpack(file, folder):
    """Unpacks a zip archive of pictures into a folder."""
    if not zipfile.is_zipfile(file):
        sys.exit(f"{file}: no zip archive; unpack it by hand")
    with zipfile.ZipFile(file) as archive:
        size = sum(member.file_size for member in archive.infolist())
        if size > MOST_BYTES * file.stat().st_size:
            sys.exit(f"{file}: {size} bytes unpacked, more than pictures can be packed to; not unpacked")
        archive.extractall(folder)
    print(f"{folder}: unpacked")


def convert(options, source, sample, *words):
    """Makes a sample of a source with `mesotex import`."""
    if options.only_fetch:
        return
    command = [options.mesotex, "import", str(source), "-o", str(sample), *words]
    command += shlex.split(options.import_options)
    print(" ".join(shlex.quote(word) for word in command), flush=True)
    try:
        code = subprocess.run(command).returncode
    except FileNotFoundError:
        sys.exit(f"{options.mesotex}: no such program; install it, or name it with --mesotex")
    if code:
        sys.exit(code)
