"""The farm with the real Slurm: `make farm-test` starts a cluster of one node for it. Not part of the gate, which has the same cases with fake_slurm.py."""
from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from ajar_farm.checkpoints import read_header
from ajar_farm.job import Job
from farm_program import BUILD, ROOT, Farm
from test_farm import image, whole


class RealFarm(Farm):
    def __init__(self, folder: Path) -> None:
        self.folder, self.job, self.environment = folder, folder / "job", dict(os.environ)

    def array(self) -> str:
        while not (self.job / "waves" / "001.id").exists():
            time.sleep(0.05)
        return (self.job / "waves" / "001.id").read_text().strip()


@pytest.fixture
def farm(tmp_path) -> RealFarm:
    assert "SLURM_CONF" in os.environ, "run `make farm-test`"
    return RealFarm(tmp_path)


def wait_for(what, seconds: float = 120.0) -> None:
    deadline = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def processes_of(part: Path) -> list[int]:
    """The renders of a part on this machine."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            command = (entry / "cmdline").read_bytes().split(b"\0")
        except (OSError, ValueError):
            continue
        if command[0].endswith(b"ajar-render") and str(part).encode() in command:
            found.append(int(entry.name))
    return found


def test_two_of_four_tasks_are_killed_at_random_moments(farm, scene, tmp_path):
    seed = int(time.time())
    print(f"seed {seed}")
    chance = random.Random(seed)
    process = farm.start(*farm.arguments(scene, "--samples", 4000, "--split", 4))
    array, job = farm.array(), Job(farm.job, Job.open(farm.job).request)
    killed, cancelled = chance.sample(range(4), 2)
    for part, act in ((killed, lambda pid: os.kill(pid, signal.SIGKILL)), (cancelled, lambda pid: subprocess.run(["scancel", f"{array}_{cancelled + 1}"], check=True))):
        path = job.partial(1, part)
        wait_for(lambda path=path: processes_of(path))
        time.sleep(chance.uniform(0.0, 1.0))
        for pid in processes_of(path):
            act(pid)
    text = process.communicate(timeout=300)[0]
    assert process.returncode == 0, text
    assert "submitted again" in text
    assert np.array_equal(image(job.output(1)), whole(scene, tmp_path, 4000))


def test_a_task_whose_node_fails_is_queued_again_and_goes_on(farm, scene, tmp_path):
    process = farm.start(*farm.arguments(scene, "--samples", 3000, "--split", 2))
    farm.array()
    job = Job.open(farm.job)
    wait_for(lambda: job.partial(1, 0).exists())
    node = subprocess.run(["sinfo", "--noheader", "--format", "%n"], capture_output=True, text=True, check=True).stdout.strip()
    subprocess.run(["scontrol", "update", f"NodeName={node}", "State=DOWN", "Reason=test"], check=True)
    time.sleep(1)
    # It may have come back by itself already (ReturnToService).
    subprocess.run(["scontrol", "update", f"NodeName={node}", "State=RESUME"], check=False, capture_output=True)
    # Slurm waits before a job that was queued again may start.
    text = process.communicate(timeout=400)[0]
    assert process.returncode == 0, text
    assert len(job.waves()) == 1, "Slurm itself has queued it again"
    assert json.loads(job.partial(1, 0).with_suffix(".json").read_text())["resumed"]["samples"] > 0
    assert np.array_equal(image(job.output(1)), whole(scene, tmp_path, 3000))


def test_a_time_limit_ends_a_task_after_its_checkpoint(farm, scene):
    # Slurm's limits are whole minutes, and its signal may come up to a minute early.
    process = farm.start(*farm.arguments(scene, "--samples", 1000000, "--split", 1, "--attempts", 1, "--slurm=--time=00:01:00", "--grace", 20))
    text = process.communicate(timeout=300)[0]
    assert process.returncode == 1 and "1 parts lack samples" in text, text
    header = read_header(farm.job / "merged" / "0001.checkpoint")
    assert header is not None and header.samples > 1


def test_the_noise_target_cancels_what_is_left(farm, scene):
    result = farm.submit(scene, "--samples", 400000, "--split", 40, "--error", 1e3)
    assert result.returncode == 0, result.stdout
    header = read_header(farm.job / "merged" / "0001.checkpoint")
    assert header is not None and header.samples < 400000
    wait_for(lambda: not subprocess.run(["squeue", "--noheader"], capture_output=True, text=True, check=True).stdout.strip())


@pytest.mark.parametrize("dump_only", [True, False])
def test_a_file_of_blender(farm, tmp_path, dump_only):
    profile = BUILD / "blender_profile"
    farm.environment |= {"BLENDER_USER_CONFIG": str(profile / "config"), "BLENDER_USER_SCRIPTS": str(profile / "scripts")}
    farm.job = tmp_path / "job"
    result = farm.submit(ROOT / "test_scenes" / "box.blend", "--frames", "1-2", "--samples", 4, "--split", 2, *(["--dump-only"] if dump_only else []), "--", "--threads", 2)
    assert result.returncode == 0, result.stdout + result.stderr
    for frame in (1, 2):
        assert image(farm.job / "output" / f"{frame:04}.exr").mean() > 0.01
    assert sorted(path.name for path in (farm.job / "scenes").iterdir()) == ["0001.ajar", "0002.ajar"]
