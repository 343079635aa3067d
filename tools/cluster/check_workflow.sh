#!/bin/sh
# A workflow of 12 materials x 2 meshes x 24 frames on a Slurm cluster of three nodes, one of which dies on the way:
# does it end, and with the files of a single machine?
#
#   check_workflow.sh DIR
#
# Needs what local_slurm.sh needs, python3, and `mesotex` and `snakemake` (9, with snakemake-executor-plugin-slurm) in
# the PATH. Takes some minutes; DIR is made, and keeps the logs.
set -eu
tools=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
dir=$(cd "$1" && pwd)
# At so many finished tasks the node dies.
kill_at=${KILL_AT:-40}
shards=${SHARDS:-2}

write_inputs() {
    mkdir -p "$1"
    cat > "$1/sweep.toml" <<'SCENE'
name = "sweep"
output = "out"

[matrix]
bake.preset = ["cobbles", "bark", "leather", "hammered", "scales", "bricks"]
bake.seed = [0, 1]
mesh.input = ["ring.obj", "bean.obj"]

[bake]
size = 32
views = "fibonacci:16"
lights = "fibonacci:16"

[textons]
textons = 60
images = 100
levels = 2

[mesh]
vertices = 4000

[[render]]
name = "turn"
sweep = "view-orbit"
frames = 24
size = "160x120"
shading = "pixel"
SCENE
    python3 - "$1" <<'MESHES'
import math, sys

def write(name, point, rings, sides):
    with open(f"{sys.argv[1]}/{name}", "w") as file:
        for ring in range(rings):
            for side in range(sides):
                turn = [2 * math.pi * ring / rings, 2 * math.pi * side / sides]
                file.write("v {:.6f} {:.6f} {:.6f}\n".format(*point(*turn)))
        for ring in range(rings):
            for side in range(sides):
                corners = [(ring + i) % rings * sides + (side + j) % sides + 1 for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))]
                file.write("f {} {} {} {}\n".format(*corners))

def ring(u, v, radius=1.0, thickness=0.4):
    return [(radius + thickness * math.cos(v)) * math.cos(u), thickness * math.sin(v),
            (radius + thickness * math.cos(v)) * math.sin(u)]

def bean(u, v):
    x, y, z = ring(u, v, 1.0, 0.3 + 0.15 * math.cos(2 * u))
    return [1.3 * x, y + 0.2 * x * x, z]

write("ring.obj", ring, 96, 40)
write("bean.obj", bean, 90, 36)
MESHES
}

# Every file with its hash, but for what belongs to one machine.
files_of() {
    (cd "$1/out" && find . -type f ! -name 'run.json' ! -name '*.html' ! -path '*cache*' ! -name '.*' \
        ! -path './*[0-9]of[0-9]*' -exec sha256sum {} + | sort -k 2)
}

finished() { grep -c '^Finished jobid' "$dir/snakemake.log" || true; }

say() { echo "$(date +%T) $*"; }

write_inputs "$dir/single"
say "a single machine"
(cd "$dir/single" && mesotex run sweep.toml --no-pages > ../single.log)
files_of "$dir/single" > "$dir/single.sums"

write_inputs "$dir/cluster"
"$tools/local_slurm.sh" start "$dir/slurm" 3
trap '"$tools/local_slurm.sh" stop "$dir/slurm"' EXIT
cd "$dir/cluster"
mesotex plan sweep.toml --shards "$shards" --format snakemake -o Snakefile
say "the workflow begins"
begun=$(date +%s)
# squeue knows finished jobs here, and short tasks are asked for often.
snakemake --profile "$tools/slurm" --slurm-status-command squeue --jobs 60 --latency-wait 5 \
    --slurm-init-seconds-before-status-checks 1 --seconds-between-status-checks 1 > "$dir/snakemake.log" 2>&1 &
engine=$!
while kill -0 $engine 2>/dev/null && [ "$(finished)" -lt "$kill_at" ]; do sleep 0.5; done
# The node dies at work.
while kill -0 $engine 2>/dev/null && [ -z "$(squeue -h -w node2 -t running)" ]; do sleep 0.2; done
squeue -h -w node2 -t running -o '%i %j %N' > "$dir/killed.jobs"
"$tools/local_slurm.sh" kill "$dir/slurm" 2
say "node2 dies after $(finished) tasks; it was at job $(cut -d' ' -f1 "$dir/killed.jobs")"
while kill -0 $engine 2>/dev/null; do
    state=$(sinfo -h -n node2 -o %T)
    if [ "$state" != "${last:-}" ]; then
        say "node2 is $state"
        last=$state
    fi
    sleep 1
done
wait $engine || { tail -n 30 "$dir/snakemake.log"; exit 1; }
say "the workflow ends after $(($(date +%s) - begun)) s, $(finished) tasks"
squeue -h -t all -S i -o '%i %T %N %S %e %k' > "$dir/jobs.txt"
files_of "$dir/cluster" > "$dir/cluster.sums"
diff "$dir/single.sums" "$dir/cluster.sums"
say "$(wc -l < "$dir/cluster.sums") files, the same bytes"
