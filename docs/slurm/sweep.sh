#!/bin/bash
# A case over values of a key, one table:  sbatch docs/slurm/sweep.sh CASE.toml 'damping.ratio=3 %,5 %,7 %,9 %'
# Rank 0 hands the variants out, each of the others runs one at a time: four of these five work.
#SBATCH --job-name=impactfem-sweep
#SBATCH --ntasks=5
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu=4G
#SBATCH --time=02:00:00
#SBATCH --output=%x-%j.log
set -euo pipefail

case=${1:?usage: sbatch docs/slurm/sweep.sh CASE.toml KEY=VALUES}
values=${2:?usage: sbatch docs/slurm/sweep.sh CASE.toml KEY=VALUES}
export OMP_NUM_THREADS=$SLURM_CPUS_PER_TASK

mpirun -n "$SLURM_NTASKS" .venv/bin/impactfem sweep "$case" --set "$values" \
  --out "runs/$(basename "$case" .toml)_sweep"
