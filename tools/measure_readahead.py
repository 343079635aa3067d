#!/usr/bin/env python3
"""Measures how reading a large sample from a cold cache depends on what the system is told of the reading.

Needs: a C compiler (cc); nothing else beside Python 3 on Linux.
Run:   tools/measure_readahead.py large.sample --pattern stripes:256 --share 0.05 --advice normal random ahead:64i
       tools/measure_readahead.py large.sample -- mesotex info large.sample

Without a command, a small program reads as mesotex does and computes nothing: --pattern image reads image after image,
stripes:N a piece of N texels of every image, then the next piece of every image. It reads --share of the sample. A
library that is loaded before the program tells the system something of the reads, once per advice:

  normal, sequential, random   posix_fadvise of the whole file radiance.npy when it is opened
  ahead:N                      posix_fadvise(WILLNEED) at every read, for as many bytes that lie N bytes further on;
                               ahead:64i is 64 images further on
  random+ahead:64i             both; the last is what mesotex tells the system where it reads pieces of many images
  map-random, map-willneed …   madvise of maps over 64 MiB: the copy of a sample that `render` keeps on disk

Before every run the system forgets the sample (posix_fadvise DONTNEED). Runs go round: every advice once, --rounds
times. Printed are medians: seconds, their ratio to the first advice in the same round, and bytes that came from the
disk. With --limit, each process runs in a control group that may take so much memory, pages of files included.
"""

import argparse
import glob
import json
import os
import statistics
import subprocess
import sys
import tempfile

from measure_shards import bytes_of, new_group, run

LIBRARY = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/types.h>

static char watched[1 << 16];
static const char *advice(void) { const char *a = getenv("READ_ADVICE"); return a ? a : "normal"; }

static void look(int fd, const char *path) {
    size_t length = strlen(path);
    if (fd < 0 || fd >= (int)sizeof watched) return;
    watched[fd] = length >= 12 && !strcmp(path + length - 12, "radiance.npy");
    if (!watched[fd]) return;
    if (!strncmp(advice(), "sequential", 10)) posix_fadvise64(fd, 0, 0, POSIX_FADV_SEQUENTIAL);
    if (!strncmp(advice(), "random", 6)) posix_fadvise64(fd, 0, 0, POSIX_FADV_RANDOM);
}

int open64(const char *path, int flags, ...) {
    static int (*real)(const char *, int, ...);
    if (!real) real = dlsym(RTLD_NEXT, "open64");
    va_list rest;
    va_start(rest, flags);
    mode_t mode = va_arg(rest, mode_t);
    va_end(rest);
    int fd = real(path, flags, mode);
    look(fd, path);
    return fd;
}

ssize_t pread64(int fd, void *bytes, size_t length, off64_t at) {
    static ssize_t (*real)(int, void *, size_t, off64_t);
    if (!real) real = dlsym(RTLD_NEXT, "pread64");
    const char *ahead = strstr(advice(), "ahead:");
    if (fd >= 0 && fd < (int)sizeof watched && watched[fd] && ahead) {
        posix_fadvise64(fd, at + strtoll(ahead + 6, 0, 10), length, POSIX_FADV_WILLNEED);
    }
    return real(fd, bytes, length, at);
}

void *mmap64(void *place, size_t length, int protection, int flags, int fd, off64_t at) {
    static void *(*real)(void *, size_t, int, int, int, off64_t);
    if (!real) real = dlsym(RTLD_NEXT, "mmap64");
    void *map = real(place, length, protection, flags, fd, at);
    if (map != MAP_FAILED && fd >= 0 && length > (64 << 20)) {
        if (strstr(advice(), "map-random")) madvise(map, length, MADV_RANDOM);
        if (strstr(advice(), "map-sequential")) madvise(map, length, MADV_SEQUENTIAL);
        if (strstr(advice(), "map-willneed")) madvise(map, length, MADV_WILLNEED);
    }
    return map;
}
"""

READER = r"""
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

int open64(const char *path, int flags, ...);

/* FILE OFFSET IMAGES BYTES_OF_IMAGE BYTES_OF_PIECE FIRST_IMAGES FIRST_PIECES */
int main(int count, char **words) {
    long long n[8];
    for (int at = 2; at < count; at++) n[at] = atoll(words[at]);
    int fd = open64(words[1], O_RDONLY);
    char *bytes = malloc(n[5]);
    for (long long piece = 0; piece < n[7]; piece++)
        for (long long image = 0; image < n[6]; image++)
            if (pread64(fd, bytes, n[5], n[2] + image * n[4] + piece * n[5]) < 0) return 1;
    return fd < 0;
}
"""


def parse():
    parser = argparse.ArgumentParser(
        description=__doc__,
        usage="%(prog)s SAMPLE [options] [-- COMMAND ...]",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("sample")
    parser.add_argument("--pattern", default="image", help="without a command: image, or stripes:TEXELS")
    parser.add_argument("--share", type=float, default=1.0, help="without a command: the share of the sample that is read")
    parser.add_argument("--advice", nargs="+", default=["normal", "sequential", "random"])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--limit", help="memory of the process, as 1GiB")
    words = sys.argv[1:] + ["--"]
    own, command = words[: words.index("--")], words[words.index("--") + 1 : -1]
    arguments = parser.parse_args(own)
    arguments.command = command
    return arguments


def built(source, path, *options):
    """A library or a program, compiled."""
    words = ["cc", "-O2", *options, "-x", "c", "-", "-o", path, "-ldl"]
    subprocess.run(words, input=source, text=True, check=True)
    return path


def description(sample):
    with open(os.path.join(sample, "btf.json"), encoding="utf-8") as file:
        return json.load(file)


def bytes_of_image(sample):
    told = description(sample)
    return told["height"] * told["width"] * 3 * (2 if told["dtype"] == "f2" else 4)


def reader(sample, pattern, share, folder):
    """The command that reads as a pattern says."""
    path = os.path.join(sample, "radiance.npy")
    image = bytes_of_image(sample)
    size = os.path.getsize(path)
    images = size // image
    first_images, piece, pieces = int(images * share), image, 1
    if pattern != "image":
        piece = int(pattern.split(":")[1]) * image // (description(sample)["height"] * description(sample)["width"])
        first_images, pieces = images, max(1, int(image / piece * share))
    program = built(READER, os.path.join(folder, "reader"))
    return [program, path, *(str(number) for number in (size % image, images, image, piece, first_images, pieces))]


def forget(sample):
    """Has the system drop the pages of a sample's files."""
    for path in glob.glob(os.path.join(sample, "*")):
        with open(path, "rb") as file:
            os.fsync(file.fileno())
            os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def main():
    arguments = parse()
    group = new_group(bytes_of(arguments.limit)) if arguments.limit else None
    if arguments.limit and not group:
        raise SystemExit("no control group can be made here: run without --limit")
    found = {advice: [] for advice in arguments.advice}
    with tempfile.TemporaryDirectory() as folder:
        library = built(LIBRARY, os.path.join(folder, "advice.so"), "-shared", "-fPIC")
        command = arguments.command or reader(arguments.sample, arguments.pattern, arguments.share, folder)
        for _ in range(arguments.rounds):
            for advice in arguments.advice:
                forget(arguments.sample)
                told = advice
                if advice.endswith("i"):
                    head, images = advice[:-1].split("ahead:")
                    told = f"{head}ahead:{int(images) * bytes_of_image(arguments.sample)}"
                environment = dict(os.environ, LD_PRELOAD=library, READ_ADVICE=told)
                found[advice].append(run(command, group, environment))
                last = found[advice][-1]
                print(f"  {advice}: {last.seconds:.1f} s, {last.read / 1e9:.2f} GB from the disk", flush=True)
    if group:
        os.rmdir(group)
    first = found[arguments.advice[0]]
    print("advice | seconds | ratio | GB from the disk")
    for advice, runs in found.items():
        seconds = statistics.median(one.seconds for one in runs)
        ratio = statistics.median(one.seconds / other.seconds for one, other in zip(runs, first))
        read = statistics.median(one.read for one in runs)
        print(f"{advice} | {seconds:.1f} | {ratio:.2f} | {read / 1e9:.2f}")


if __name__ == "__main__":
    main()
