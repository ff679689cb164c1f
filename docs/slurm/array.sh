#!/bin/bash
# Many cases, each a job of its own:  sbatch --array=1-$(wc -l < cases.txt) docs/slurm/array.sh cases.txt
# cases.txt names one case file a line.
#SBATCH --job-name=impactfem
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=2
#SBATCH --mem=8G
#SBATCH --time=01:00:00
#SBATCH --output=%x-%A_%a.log
set -euo pipefail

list=${1:?usage: sbatch --array=1-N docs/slurm/array.sh LIST}
case=$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$list")
export OMP_NUM_THREADS=$SLURM_CPUS_PER_TASK

.venv/bin/impactfem run "$case" --out "runs/$(basename "$case" .toml)"
