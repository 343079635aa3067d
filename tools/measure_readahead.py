#!/usr/bin/env python3
"""Measures how a command that reads a large sample from a cold cache depends on what the system is told of the reading.

Needs: a C compiler (cc); nothing else beside Python 3 on Linux.
Run:   tools/measure_readahead.py large.sample -- mesotex info large.sample

mesotex reads samples by position (pread), and tells the system nothing. Here a small library that is loaded before the
program tells it something in its place, once per advice:

  normal, sequential, random   posix_fadvise of the whole file radiance.npy when it is opened
  ahead:N[:M]                  posix_fadvise(WILLNEED) at every read, for the M bytes that lie N bytes further on;
                               M is the length of the read where it is not given
  map-random, map-willneed …   madvise of maps over 64 MiB: the copy of a sample that `render` keeps on disk

Before every run the system forgets the sample (posix_fadvise DONTNEED). Runs go round: every advice once, --rounds
times. Printed are medians: seconds, their ratio to the first advice in the same round, and bytes that came from the
disk. With --limit, each process runs in a control group that may take so much memory, pages of files included.
"""

import argparse
import glob
import os
import statistics
import subprocess
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
    if (!strcmp(advice(), "sequential")) posix_fadvise64(fd, 0, 0, POSIX_FADV_SEQUENTIAL);
    if (!strcmp(advice(), "random")) posix_fadvise64(fd, 0, 0, POSIX_FADV_RANDOM);
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
    if (fd >= 0 && fd < (int)sizeof watched && watched[fd] && !strncmp(advice(), "ahead:", 6)) {
        char *rest;
        off64_t further = strtoll(advice() + 6, &rest, 10);
        off64_t size = *rest == ':' ? strtoll(rest + 1, 0, 10) : (off64_t)length;
        posix_fadvise64(fd, at + further, size, POSIX_FADV_WILLNEED);
    }
    return real(fd, bytes, length, at);
}

void *mmap64(void *place, size_t length, int protection, int flags, int fd, off64_t at) {
    static void *(*real)(void *, size_t, int, int, int, off64_t);
    if (!real) real = dlsym(RTLD_NEXT, "mmap64");
    void *map = real(place, length, protection, flags, fd, at);
    if (map != MAP_FAILED && fd >= 0 && length > (64 << 20)) {
        if (!strcmp(advice(), "map-random")) madvise(map, length, MADV_RANDOM);
        if (!strcmp(advice(), "map-sequential")) madvise(map, length, MADV_SEQUENTIAL);
        if (!strcmp(advice(), "map-willneed")) madvise(map, length, MADV_WILLNEED);
    }
    return map;
}
"""


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sample")
    parser.add_argument("command", nargs="+", help="after --; its outputs are written over by every run")
    parser.add_argument("--advice", nargs="+", default=["normal", "sequential", "random"])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--limit", help="memory of the process, as 1GiB")
    return parser.parse_args()


def built(folder):
    """The library, compiled."""
    path = os.path.join(folder, "advice.so")
    words = ["cc", "-shared", "-fPIC", "-O2", "-x", "c", "-", "-o", path, "-ldl"]
    subprocess.run(words, input=LIBRARY, text=True, check=True)
    return path


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
        library = built(folder)
        for _ in range(arguments.rounds):
            for advice in arguments.advice:
                forget(arguments.sample)
                environment = dict(os.environ, LD_PRELOAD=library, READ_ADVICE=advice)
                found[advice].append(run(arguments.command, group, environment))
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
