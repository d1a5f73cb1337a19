#!/bin/sh
# Submits «shards» shards of a campaign as a job array, and their merge. Options of sbatch may follow, for both:
#   sh slurm.sh --time=04:00:00 --cpus-per-task=4
cd «here» || exit
array=$(sbatch --parsable --job-name=«name» --array=1-«shards» --output=«folder»/slurm-%A_%a.log --open-mode=append \
  --requeue --signal=TERM@60 "$@" <<'SHARD'
#!/bin/bash
export RAYON_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}
srun «sample» --shard $SLURM_ARRAY_TASK_ID/«shards»
code=$?
# Stopped a minute before its time was up, with everything stored: the same task again.
if [ $code -eq 3 ]; then scontrol requeue "$SLURM_JOB_ID"; fi
exit $code
SHARD
) || exit
echo "Submitted array job $array"
sbatch --job-name=«name» --output=«folder»/slurm-%j.log --dependency="afterok:$array" --kill-on-invalid-dep=yes "$@" <<'MERGE'
#!/bin/bash
«merge»
MERGE
