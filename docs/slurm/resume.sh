#!/bin/bash
# A run that is longer than a job may be:  sbatch docs/slurm/resume.sh CASE.toml
# Two minutes before its time is up the job stops the run and puts itself into the queue again;
# the next one goes on where this one was.
#SBATCH --job-name=impactfem
#SBATCH --ntasks=4
#SBATCH --cpus-per-task=1
#SBATCH --mem=16G
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:USR1@120
#SBATCH --output=%x-%j.log
set -euo pipefail

case=${1:?usage: sbatch docs/slurm/resume.sh CASE.toml}
out=runs/$(basename "$case" .toml)
export OMP_NUM_THREADS=$SLURM_CPUS_PER_TASK

again() {
  kill "$run" 2>/dev/null || true
  wait "$run" || true
  scontrol requeue "$SLURM_JOB_ID"
  exit 0
}

resume=
[ ! -f "$out/run.log" ] || resume=--resume
# In the background, so that the shell hears the signal while it waits.
mpirun -n "$SLURM_NTASKS" .venv/bin/impactfem run "$case" --out "$out" $resume &
run=$!
trap again USR1
wait "$run"
