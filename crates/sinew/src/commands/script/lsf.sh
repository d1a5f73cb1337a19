#!/bin/sh
# Submits «shards» shards of a campaign as a job array, and their merge. Options of bsub may follow, for both:
#   sh lsf.sh -W 240 -n 4
cd «here» || exit
# A task that is stopped a minute before its time is up, with everything stored, ends with 3 and begins again.
told=$(bsub -J «name»"[1-«shards»]" -o «folder»/lsf-%J-%I.log -Q 3 -wa TERM -wt 1 "$@" <<'SHARD'
#!/bin/bash
export RAYON_NUM_THREADS=${LSB_DJOB_NUMPROC:-1}
exec «sample» --shard $LSB_JOBINDEX/«shards»
SHARD
) || exit
array=$(echo "$told" | sed -n 's/^Job <\([0-9]*\)>.*/\1/p')
echo "Submitted array job $array"
bsub -J «name» -o «folder»/lsf-%J.log -w "done($array)" "$@" <<'MERGE'
#!/bin/bash
«merge»
MERGE
