#!/bin/sh
# Submits a plan to Slurm: an array of jobs for each step, which begins when the whole step before has ended well.
#
#   mesotex plan scene.toml --shards 8 --format shell -o plan.sh
#   slurm_array.sh plan.sh [options of sbatch]
#
# as `slurm_array.sh plan.sh --partition=long --time=60`. Every job asks for twice the memory that its step's largest
# task is expected to take. Jobs of a node that dies are put in the queue again. Output goes to slurm-logs/.
# Prints the numbers of the jobs; the last one ends when all is done.
set -eu

# In a job: runs the line of its step that its number in the array says.
if [ "${MESOTEX_STEP:-}" ]; then
    line=$((MESOTEX_FIRST + SLURM_ARRAY_TASK_ID))
    command=$(awk -v step="$MESOTEX_STEP" -v line="$line" \
        '/^# step / { at = $3; next } at == step && ++count == line' "$MESOTEX_PLAN")
    begin=$(date +%s.%N)
    eval "$command"
    # tools/simulate_cluster.py reads this line.
    echo "$(hostname) $begin $(date +%s.%N): $command"
    exit
fi

plan=$1
shift
mkdir -p slurm-logs
largest=$(scontrol show config | sed -n 's/^MaxArraySize *= *//p')
steps=$(sed -n 's/^# step 1 of \([0-9]*\).*/\1/p' "$plan")
before=
for step in $(seq "$steps"); do
    head=$(grep "^# step $step of " "$plan")
    count=$(awk -v step="$step" '/^# step / { at = $3; next } at == step' "$plan" | wc -l)
    mebibytes=$(echo "$head" | sed -n 's/.* \([0-9]*\) MiB$/\1/p')
    first=0
    jobs=
    while [ "$first" -lt "$count" ]; do
        size=$((count - first))
        [ "$size" -lt "$largest" ] || size=$((largest - 1))
        job=$(MESOTEX_PLAN="$plan" MESOTEX_STEP="$step" MESOTEX_FIRST="$first" sbatch --parsable --requeue \
            --job-name="mesotex-$step" --array="1-$size" --mem="$((2 * ${mebibytes:-50}))" --export=ALL \
            --output=slurm-logs/step-"$step"-%A-%a.txt ${before:+--dependency=afterok:$before} \
            --kill-on-invalid-dep=yes "$@" "$0" "$plan")
        jobs="${jobs:+$jobs:}${job%%;*}"
        first=$((first + size))
    done
    echo "step $step of $steps: job $jobs, $count tasks"
    before=$jobs
done
