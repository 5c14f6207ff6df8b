#!/usr/bin/env bash
# Simplifies a mesh larger than memory with Slurm: one job array for each step, each after the one before.
#
#     docs/slurm/simplify.sh huge.ply small.ply /shared/work --ratio 0.01
#     docs/slurm/simplify.sh huge.ply levels /shared/work --levels 0.3,0.1,0.01
#
# JOBS is the largest number of jobs of an array, MEMORY the memory limit of each job, and JOB_MEMORY the memory
# that Slurm gives it, which should be more.
set -euo pipefail

input=$1 output=$2 work=$3
shift 3
jobs=${JOBS:-64} memory=${MEMORY:-6G}
submit=(sbatch --parsable --wait --cpus-per-task=4 --mem="${JOB_MEMORY:-8G}")

# The arrays of one level: as many jobs as there are cells, but no more than allowed.
array() {
  local step=$1 level=$2 cells=$3
  local count=$((cells < jobs ? cells : jobs))
  "${submit[@]}" --array="1-$count" --wrap \
    "curvmesh region $step '$work' --level $level --shard \$SLURM_ARRAY_TASK_ID/$count"
}

# A value of a line of JSON.
value() { sed -E "s/.*\"$1\":\"?([a-z0-9_]+)\"?.*/\1/"; }

"${submit[@]}" --wrap "curvmesh region split '$input' -w '$work' --memory $memory $*"
while true; do
  plan=$(curvmesh region plan "$work" --json)
  level=$(value level <<<"$plan") cells=$(value cells <<<"$plan")
  # A result that does not fit into a job's memory is finished cell by cell.
  if grep -q '"apart"' <<<"$plan"; then
    array finish "$level" "$cells"
  fi
  case $(value next <<<"$plan") in
    pass)
      array reduce "$level" "$cells"
      array join $((level + 1)) "$(value joined <<<"$plan")" ;;
    strips) array join $((level + 1)) 1 ;; # one job collapses all rims, and makes all cells
    *) break ;;
  esac
done
"${submit[@]}" --wrap "curvmesh region finish '$work' -o '$output'"
