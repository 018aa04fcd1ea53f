#!/usr/bin/env python3
"""sbatch, squeue and scancel for one machine without Slurm, by the name under which this file is called. The state is in the folder $FAKE_SLURM.

A task is a process of its script. What happens to it can be decided by a test: the file `orders` has lines "INDEX SIGNAL FILE": task INDEX of any array gets the signal
in its first run, as soon as the file exists. After SIGKILL of the order "node" (number 99), it is queued again, as Slurm does when a node fails.
"""
from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

STATE = Path(os.environ["FAKE_SLURM"])
NODE_FAILS = 99


def orders() -> dict[int, tuple[int, Path]]:
    try:
        lines = (STATE / "orders").read_text().splitlines()
    except FileNotFoundError:
        return {}
    return {int(index): (int(number), Path(file)) for index, number, file in (line.split(maxsplit=2) for line in lines)}


def run_task(folder: Path, script: str, index: int) -> None:
    """In a process of its own: waits for a slot, runs the task unless it is cancelled before, follows the order."""
    queued = folder / f"{index}.queued"
    slots = int(os.environ.get("FAKE_SLOTS", "2"))
    while True:
        running = list(STATE.glob("*/*.running"))
        if len(running) < slots:
            break
        time.sleep(0.02)
    if not queued.exists():
        return
    order = orders().get(index)
    marker, log = folder / f"{index}.running", (folder / f"{index}.log").open("ab")
    marker.touch()
    for again in (False, True):
        task = subprocess.Popen(["bash", script], stdout=log, stderr=log, env={**os.environ, "SLURM_ARRAY_TASK_ID": str(index), "SLURM_JOB_ID": f"{folder.name}{index}", "SLURM_CPUS_PER_TASK": "1"})
        (folder / f"{index}.pid").write_text(str(task.pid))
        (STATE / "runs").open("a").write(f"{folder.name} {index}\n")
        if order is not None and not again and not (STATE / f"obeyed.{index}").exists():
            (STATE / f"obeyed.{index}").touch()
            number, file = order
            while task.poll() is None and not file.exists():
                time.sleep(0.005)
            task.send_signal(signal.SIGKILL if number == NODE_FAILS else number)
            task.wait()
            if number == NODE_FAILS:
                continue
        task.wait()
        break
    marker.unlink(missing_ok=True)
    queued.unlink(missing_ok=True)


def sbatch(arguments: list[str]) -> int:
    script = arguments[-1]
    last = next(int(argument.partition("-")[2].rpartition("-")[2]) for argument in arguments if argument.startswith("--array"))
    number = sum(path.is_dir() for path in STATE.iterdir()) + 1
    folder = STATE / str(number)
    folder.mkdir()
    for index in range(1, last + 1):
        (folder / f"{index}.queued").touch()
    for index in range(1, last + 1):
        if os.fork() == 0:
            os.setsid()
            for descriptor in (0, 1, 2):
                os.dup2(os.open(os.devnull, os.O_RDWR), descriptor)
            run_task(folder, script, index)
            os._exit(0)
    print(number)
    return 0


def squeue(arguments: list[str]) -> int:
    folder = STATE / arguments[arguments.index("--jobs") + 1]
    for path in folder.glob("*.queued"):
        print(path.stem, "RUNNING" if path.with_suffix(".running").exists() else "PENDING")
    return 0


def scancel(arguments: list[str]) -> int:
    for name in arguments:
        array, _, index = name.partition("_")
        with (STATE / "cancelled").open("a") as file:
            file.write(name + "\n")
        try:
            os.kill(int((STATE / array / f"{index}.pid").read_text()), signal.SIGTERM)
        except (FileNotFoundError, ProcessLookupError):
            (STATE / array / f"{index}.queued").unlink(missing_ok=True)
    return 0


sys.exit({"sbatch": sbatch, "squeue": squeue, "scancel": scancel}[Path(sys.argv[0]).name](sys.argv[1:]))
