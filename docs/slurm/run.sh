#!/bin/bash
# One case over the ranks of a job:  sbatch docs/slurm/run.sh CASE.toml
#SBATCH --job-name=impactfem
#SBATCH --ntasks=4
#SBATCH --cpus-per-task=1
#SBATCH --mem=32G
#SBATCH --time=02:00:00
#SBATCH --output=%x-%j.log
set -euo pipefail

case=${1:?usage: sbatch docs/slurm/run.sh CASE.toml}
export OMP_NUM_THREADS=$SLURM_CPUS_PER_TASK   # threads of each rank

mpirun -n "$SLURM_NTASKS" .venv/bin/impactfem run "$case" --out "runs/$(basename "$case" .toml)"
