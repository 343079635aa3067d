#!/usr/bin/env python3
"""A discrete-event simulation of a plan on many machines (docs/scale.md).

    simulate_cluster.py terms LOGS -o terms.json          what tasks took, from the logs of slurm_array.sh
    simulate_cluster.py makespan LOGS                     when the first task began and the last ended
    simulate_cluster.py plan PLAN.json --nodes 3          the makespan of a plan of `mesotex plan`
    simulate_cluster.py scale --nodes 100                 many materials and frames, by the terms of docs/scale.md

Machines have slots, one task each. A task waits for those before it and for a slot, is started (--start seconds), reads
and writes through a file system that all machines share (--bandwidth for all together, --link for one transfer),
creates its files (--creates per second for all together), and computes. Transfers share the bandwidth evenly.
"""

import argparse
import glob
import heapq
import json
import math
import os
import re
import sys
from collections import defaultdict
from dataclasses import dataclass, field


@dataclass
class Task:
    """What the simulation knows of a task."""

    stage: str
    seconds: float
    after: list = field(default_factory=list)
    reads: float = 0.0
    writes: float = 0.0
    files: int = 1
    step: int = 0


@dataclass
class Cluster:
    nodes: int
    slots: int
    start: float = 0.0
    bandwidth: float = math.inf
    link: float = math.inf
    creates: float = math.inf
    has_steps: bool = False
    between_steps: float = 0.0


class Transfers:
    """Transfers that share a bandwidth evenly: everyone's progress is one number, bytes since the beginning."""

    def __init__(self, cluster):
        self.cluster, self.now, self.moved, self.heap = cluster, 0.0, 0.0, []
        self.busy = 0.0

    def rate(self):
        return min(self.cluster.bandwidth / max(1, len(self.heap)), self.cluster.link)

    def advance(self, now):
        if self.heap:
            # Busy is the share of the whole bandwidth that was in use.
            self.moved += (now - self.now) * self.rate()
            self.busy += (now - self.now) * min(1.0, self.rate() * len(self.heap) / self.cluster.bandwidth)
        self.now = now

    def add(self, now, size, task):
        self.advance(now)
        heapq.heappush(self.heap, (self.moved + size, task))

    def next_end(self):
        return self.now + max(0.0, self.heap[0][0] - self.moved) / self.rate() if self.heap else math.inf

    def pop(self, now):
        self.advance(now)
        return heapq.heappop(self.heap)[1]


def simulate(tasks, cluster):
    """The makespan, and how much of it machines computed, waited for the file system, and created files."""
    waiting = [len(task.after) for task in tasks]
    followers = defaultdict(list)
    for at, task in enumerate(tasks):
        for before in task.after:
            followers[before].append(at)
    left_in_step = defaultdict(int)
    for task in tasks:
        left_in_step[task.step] += 1
    steps = sorted(left_in_step)
    step_open = {step: not cluster.has_steps or step == steps[0] for step in steps}
    held = defaultdict(list)
    ready, events, transfers = [], [], Transfers(cluster)
    free, now, creator_free = cluster.nodes * cluster.slots, 0.0, 0.0
    sums = defaultdict(float)
    order = 0

    def make_ready(at):
        if step_open[tasks[at].step]:
            heapq.heappush(ready, at)
        else:
            held[tasks[at].step].append(at)

    def push(when, kind, at):
        nonlocal order
        heapq.heappush(events, (when, order, kind, at))
        order += 1

    def move(size, kind, at):
        if size > 0 and cluster.bandwidth < math.inf:
            transfers.add(now, size, (kind, at))
        else:
            push(now, kind, at)

    for at, count in enumerate(waiting):
        if count == 0:
            make_ready(at)
    began = {}
    while True:
        while free and ready:
            at = heapq.heappop(ready)
            free -= 1
            began[at] = now
            sums["start"] += cluster.start
            push(now + cluster.start, "read", at)
        when = min(events[0][0] if events else math.inf, transfers.next_end())
        if when == math.inf:
            break
        now = when
        if events and events[0][0] <= transfers.next_end():
            _, _, kind, at = heapq.heappop(events)
        else:
            kind, at = transfers.pop(now)
        task = tasks[at]
        if kind == "read":
            move(task.reads, "compute", at)
        elif kind == "compute":
            sums["compute"] += task.seconds
            push(now + task.seconds, "write", at)
        elif kind == "write":
            move(task.writes, "create", at)
        elif kind == "create":
            creator_free = max(creator_free, now) + task.files / cluster.creates
            push(creator_free, "end", at)
        elif kind == "open":
            step_open[at] = True
            for other in held.pop(at, []):
                heapq.heappush(ready, other)
        else:
            free += 1
            sums["slots"] += now - began[at]
            for follower in followers[at]:
                waiting[follower] -= 1
                if waiting[follower] == 0:
                    make_ready(follower)
            left_in_step[task.step] -= 1
            if cluster.has_steps and left_in_step[task.step] == 0:
                later = [step for step in steps if step > task.step]
                if later:
                    push(now + cluster.between_steps, "open", later[0])
    capacity = now * cluster.nodes * cluster.slots
    return now, {
        "computing": sums["compute"] / capacity,
        "starting": sums["start"] / capacity,
        "file system": (sums["slots"] - sums["compute"] - sums["start"]) / capacity,
        "idle": 1.0 - sums["slots"] / capacity,
        "bandwidth in use": transfers.busy / now,
    }


# --- measured runs -------------------------------------------------------------------------------------------------

LINE = re.compile(r"^(\S+) (\d+\.\d+) (\d+\.\d+): (.*)$")


def kind_of(command):
    """A task's command, and whether it is a part or joins parts."""
    words = re.search(r"mesotex (.*?)\)?$", command)
    if not words:
        return "folders"
    words = words.group(1)
    part = " part" if "--shard=" in words and not words.startswith("render") else " reduce" if "--reduce=" in words else ""
    return words.split()[0] + part


def logged(folder):
    """What was logged of every task: machine, begin, end, command, step."""
    found = []
    for path in sorted(glob.glob(os.path.join(folder, "step-*.txt"))):
        step = int(os.path.basename(path).split("-")[1])
        with open(path, encoding="utf-8", errors="replace") as file:
            matches = [LINE.match(line.rstrip("\n")) for line in file]
        found.extend((m[1], float(m[2]), float(m[3]), m[4], step) for m in matches if m)
    if not found:
        sys.exit(f"{folder}: no task in the logs; expected those of slurm_array.sh")
    return found


def terms(folder):
    """Mean seconds of every kind of task."""
    seconds = defaultdict(list)
    for _, begin, end, command, _ in logged(folder):
        seconds[kind_of(command)].append(end - begin)
    return {kind: mean(values) for kind, values in seconds.items()}


def mean(values):
    return sum(values) / len(values) if values else 0.0


def gap_between_tasks(folder):
    """Seconds between a task's end and the begin of the next on the same machine in the same step."""
    spans = defaultdict(list)
    for machine, begin, end, _, step in logged(folder):
        spans[machine, step].append((begin, end))
    found = []
    for tasks in spans.values():
        tasks.sort()
        found.extend(after[0] - before[1] for before, after in zip(tasks, tasks[1:]))
    return mean(found)


def gap_between_steps(folder):
    """Seconds between the last end in a step and the first begin in the next."""
    ends, begins = defaultdict(float), defaultdict(lambda: math.inf)
    for _, begin, end, _, step in logged(folder):
        ends[step], begins[step] = max(ends[step], end), min(begins[step], begin)
    return mean([begins[step + 1] - ends[step] for step in ends if step + 1 in ends])


def makespan(folder):
    tasks = logged(folder)
    return max(task[2] for task in tasks) - min(task[1] for task in tasks)


def tasks_of(plan, measured):
    """The tasks of a plan: measured seconds where there are some, those of the plan's model else."""
    at = {task["id"]: index for index, task in enumerate(plan["tasks"])}
    tasks = [Task("folders", measured.get("folders", 0.01), [], step=0)]
    for task in plan["tasks"]:
        kind = kind_of(" ".join(task["command"]))
        seconds = measured.get(kind, task["seconds"] or 0.0)
        after = [at[name] + 1 for name in task["after"]] or [0]
        tasks.append(Task(task["stage"], seconds, after, step=task["step"]))
    return tasks


# --- many materials and frames -------------------------------------------------------------------------------------

MB = 1e6
# What one material takes: 128 x 128 texels, 60 x 60 images, 400 textons, a mesh of 60,000 vertices, frames of 1280 x 960.
# Seconds of one thread, bytes read and written, files made; docs/scale.md says which of them were measured.
STAGES = {
    "bake": Task("bake", 3.2, [], 0, 354 * MB, 3),
    "textons": Task("textons", 41.7, [], 354 * MB, 93 * MB, 1),
    "gram": Task("gram", 0.1, [], 93 * MB, 1 * MB, 1),
    "knn": Task("knn", 0.7, [], 1 * MB, 2 * MB, 1),
    "synth": Task("synth", 7.1, [], 96 * MB, 4 * MB, 1),
}
RENDER_ONCE, RENDER_FRAME = 1.1, 0.21
RENDER_READS = 358 * MB
FRAME_BYTES, FRAME_FILES = 11.8 * MB, 2


def copy_of(name, after):
    task = STAGES[name]
    return Task(task.stage, task.seconds, after, task.reads, task.writes, task.files)


def farm(materials, frames, frames_of_task, frame_bytes, frame_files):
    """The chain of every material, its frames in tasks of so many."""
    tasks = []
    for _ in range(materials):
        first = len(tasks)
        tasks.append(copy_of("bake", []))
        tasks.append(copy_of("textons", [first]))
        tasks.append(copy_of("gram", [first + 1]))
        tasks.append(copy_of("knn", [first + 2]))
        tasks.append(copy_of("synth", [first + 3]))
        for begin in range(0, frames, frames_of_task):
            count = min(frames_of_task, frames - begin)
            seconds = RENDER_ONCE + count * RENDER_FRAME
            tasks.append(Task("render", seconds, [first + 4], RENDER_READS, count * frame_bytes, count * frame_files))
    return tasks


def scale(options):
    print("frames per task | tasks | hours | computing | starting | file system | idle | bandwidth in use")
    for frames_of_task in options.frames_of_task:
        tasks = farm(options.materials, options.frames, frames_of_task, options.frame_bytes * MB, options.frame_files)
        seconds, shares = simulate(tasks, cluster_of(options))
        cells = [f"{100 * share:.0f} %" for share in shares.values()]
        print(f"{frames_of_task} | {len(tasks)} | {seconds / 3600:.2f} | " + " | ".join(cells))


def cluster_of(options):
    return Cluster(
        options.nodes,
        options.slots,
        options.start,
        options.bandwidth * MB,
        options.link * MB,
        options.creates,
        getattr(options, "steps", False),
        getattr(options, "between_steps", 0.0),
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("terms", "makespan"):
        command = commands.add_parser(name)
        command.add_argument("logs")
        if name == "terms":
            command.add_argument("-o", "--output")
    for name in ("plan", "scale"):
        command = commands.add_parser(name)
        command.add_argument("--nodes", type=int, default=3)
        command.add_argument("--slots", type=int, default=1, help="tasks that a machine runs at once")
        command.add_argument("--start", type=float, default=0.0, help="seconds until a task runs")
        command.add_argument("--bandwidth", type=float, default=math.inf, help="MB/s of the shared file system")
        command.add_argument("--link", type=float, default=math.inf, help="MB/s of one transfer at most")
        command.add_argument("--creates", type=float, default=math.inf, help="files made per second, all together")
        if name == "plan":
            command.add_argument("plan")
            command.add_argument("--terms", help="what tasks took, of `terms`")
            command.add_argument("--steps", action="store_true", help="a step begins when the one before has ended")
            command.add_argument("--between-steps", type=float, default=0.0, help="seconds from step to step")
        else:
            command.add_argument("--materials", type=int, default=1000)
            command.add_argument("--frames", type=int, default=10000)
            command.add_argument("--frames-of-task", type=int, nargs="+", default=[100, 300, 1000, 10000])
            command.add_argument("--frame-bytes", type=float, default=FRAME_BYTES / MB, help="MB of a frame")
            command.add_argument("--frame-files", type=int, default=FRAME_FILES, help="files of a frame")
    options = parser.parse_args()
    if options.command == "terms":
        found = terms(options.logs)
        found["between tasks"] = gap_between_tasks(options.logs)
        found["between steps"] = gap_between_steps(options.logs)
        text = json.dumps(found, indent=1)
        if options.output:
            with open(options.output, "w", encoding="utf-8") as file:
                file.write(text + "\n")
        else:
            print(text)
    elif options.command == "makespan":
        print(f"{makespan(options.logs):.1f} s, {len(logged(options.logs))} tasks")
    elif options.command == "plan":
        with open(options.plan, encoding="utf-8") as file:
            plan = json.load(file)
        measured = {}
        if options.terms:
            with open(options.terms, encoding="utf-8") as file:
                measured = json.load(file)
            # The first tasks of a step are started within the time from step to step.
            options.start = options.start or measured.get("between tasks", 0.0)
            steps = measured.get("between steps", 0.0)
            options.between_steps = options.between_steps or max(0.0, steps - options.start)
        seconds, shares = simulate(tasks_of(plan, measured), cluster_of(options))
        print(f"{seconds:.1f} s: " + ", ".join(f"{100 * share:.0f} % {name}" for name, share in shares.items()))
    else:
        scale(options)


if __name__ == "__main__":
    main()
