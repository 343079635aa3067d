#!/bin/sh
# Runs a plan with GNU parallel, step after step:
#
#   mesotex plan scene.toml --shards 8 --format shell -o plan.sh
#   parallel_steps.sh plan.sh [options of parallel]
#
# as `parallel_steps.sh plan.sh --jobs 8`, or `--sshloginfile machines --workdir .` on machines that share the folder.
# A task that fails is tried twice more; then the rest is given up, and the same command goes on where it ended.
set -eu
plan=$1
shift
steps=$(sed -n 's/^# step 1 of \([0-9]*\).*/\1/p' "$plan")
for step in $(seq "$steps"); do
    echo "step $step of $steps" >&2
    awk -v step="$step" '/^# step / { at = $3; next } at == step' "$plan" |
        parallel --will-cite --halt soon,fail=1 --retries 3 "$@"
done
