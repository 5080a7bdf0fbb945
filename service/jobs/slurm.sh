#!/bin/bash
# A batch of a folder on a shared file system: sbatch slurm.sh MODELS PICTURES
#SBATCH --job-name=overcoat
#SBATCH --array=0-63
#SBATCH --cpus-per-task=2
#SBATCH --mem=4G
#SBATCH --time=04:00:00
#SBATCH --requeue
# The program is told 30 seconds before the end: it finishes what it has begun, and the next attempt goes on.
#SBATCH --signal=TERM@30
set -u
overcoat-service batch "$1" -o "$2" --shard auto --resume --size 512 --workers "${SLURM_CPUS_PER_TASK:-2}" --memory 1500Mi
code=$?
# Models without a picture are in the report.
if [ "$code" = 1 ]; then exit 0; fi
exit "$code"
