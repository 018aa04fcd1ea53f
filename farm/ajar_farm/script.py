"""The script of an array of tasks. It is meant to be read, and to be edited where a cluster is special."""

from __future__ import annotations

import shlex

from .job import Job

_TEMPLATE = """\
#!/bin/bash
# Task N of this array renders what line N of {tasks} says: frame, part, first sample, samples.
#SBATCH --job-name={name}
#SBATCH --output={logs}/%A_%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
# Before a time limit ends the task, it is told to write a checkpoint.
#SBATCH --signal=B:TERM@{grace}
{extra}
set -u
job={job}
read -r frame part first samples < <(sed -n "${{SLURM_ARRAY_TASK_ID}}p" {tasks})
scene={scene}
checkpoint=$job/partial/$frame/$part.checkpoint
mkdir -p "$job/partial/$frame"
{dump}
# A task that was killed and queued again finds its checkpoint and goes on from there. `exec` passes signals to the program.
exec {render} "$scene" "$job/partial/$frame/$part.exr" --continue "$checkpoint" --checkpoint-interval {interval} \\
  --seed {seed} --first-sample "$((10#$first))" --seconds 0 --error 0 --samples "$((10#$samples))" \\
  --threads "${{SLURM_CPUS_PER_TASK:-${{SLURM_CPUS_ON_NODE:-0}}}}" \\
  --stats "$job/partial/$frame/$part.json" {options}
"""

_DUMP = """\
# The first task of a frame writes its scene. If several do so at the same time, the last one wins; all of them write the same.
if [ ! -f "$scene" ]; then
  own=$job/scenes/$frame.$SLURM_JOB_ID.ajar
  {blender} -b {file} --addons ajar_render -E AJAR -o "${{TMPDIR:-/tmp}}/ajar-farm-$SLURM_JOB_ID-" -F PNG -f "$((10#$frame))" \\
    -- --ajar-dump-scene "$own" --ajar-dump-only on || true
  rm -f "${{TMPDIR:-/tmp}}/ajar-farm-$SLURM_JOB_ID-"*
  [ -f "$own" ] && mv "$own" "$scene"
fi
"""


def array_script(job: Job, wave: int) -> str:
    r = job.request
    q = shlex.quote
    if r.scene.endswith(".ajar"):
        before, found, after = r.scene.partition("####")
        scene = f"{q(before)}$frame{q(after)}" if found else q(r.scene)
    else:
        scene = "$job/scenes/$frame.ajar"
    dump = "" if r.scene.endswith(".ajar") or r.dump_only else _DUMP.format(blender=q(r.blender), file=q(r.scene))
    return _TEMPLATE.format(name=f"ajar-{job.folder.name}", tasks=q(str(job.wave(wave, "tasks"))), logs=job.folder / "logs", job=q(str(job.folder)), grace=r.grace,
                            extra="".join(f"#SBATCH {option}\n" for option in r.slurm), scene=scene, dump=dump, render=q(r.render), interval=r.checkpoint_interval,
                            seed=r.seed, options=shlex.join(r.options))
