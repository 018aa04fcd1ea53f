"""The four commands of Slurm that are used: sbatch, squeue, scancel. Nothing here needs accounting (slurmdbd)."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from pathlib import Path

from .job import FarmError

LONGEST_ARRAY = 1000   # the default of Slurm's MaxArraySize is 1001, and its largest index is one less


def _run(*command: str) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    except FileNotFoundError:
        raise FarmError(f"{command[0]} is not installed here: a machine of the cluster is needed, where Slurm's commands are.") from None
    except subprocess.TimeoutExpired:
        raise FarmError(f"{command[0]} has not answered for two minutes.") from None
    if done.returncode != 0:
        raise FarmError(f"{command[0]}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


def submit(script: Path, tasks: int) -> str:
    """Submits an array with the indices 1 to `tasks`, and returns its number."""
    return _run("sbatch", "--parsable", f"--array=1-{tasks}", str(script)).strip().partition(";")[0]


def queued(array: str) -> set[int] | None:
    """The indices of an array that run or wait. Empty if the array has ended; None if Slurm does not answer now."""
    try:
        text = _run("squeue", "--noheader", "--array", "--jobs", array, "--states", "all", "--format", "%K %T")
    except FarmError as error:
        # After MinJobAge, Slurm forgets a job that has ended.
        return set() if "Invalid job id" in str(error) else None
    running = set()
    for line in text.splitlines():
        index, _, state = line.partition(" ")
        if index.isdigit() and state in {"PENDING", "RUNNING", "SUSPENDED", "COMPLETING", "CONFIGURING", "REQUEUED", "REQUEUE_HOLD", "SPECIAL_EXIT", "RESIZING", "STOPPED"}:
            running.add(int(index))
    return running


def cancel(array: str, indices: Iterable[int]) -> None:
    names = [f"{array}_{index}" for index in indices]
    for at in range(0, len(names), 200):
        try:
            _run("scancel", *names[at:at + 200])
        except FarmError as error:   # one that has ended in the meantime
            if "Invalid job id" not in str(error):
                raise
