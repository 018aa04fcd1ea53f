"""The farm with a Slurm that is none: tasks are killed, checkpoints damaged, disks full, submitters two. `make farm-test` does the same with the real one."""
from __future__ import annotations

import os
import resource
import signal
import subprocess
import time
from pathlib import Path

import ajar
import numpy as np
from ajar_farm.checkpoints import read_header
from ajar_farm.commands import frames_of
from ajar_farm.job import Job
from farm_program import BUILD, NODE_FAILS


def image(path: Path) -> np.ndarray:
    return np.asarray(ajar.read_image(str(path)))


def whole(scene: Path, folder: Path, samples: int) -> np.ndarray:
    """The image of one machine that renders all samples."""
    subprocess.run([str(BUILD / "ajar-render"), str(scene), str(folder / "whole.exr"), "--first-sample", "0", "--samples", str(samples), "--seed", "3", "--integrator", "path"],
                   check=True, capture_output=True)
    return image(folder / "whole.exr")


def test_four_tasks_of_which_two_are_killed_make_the_image_of_one_machine_bit_for_bit(farm, scene, tmp_path):
    # One is killed by its node, which Slurm queues again; one is cancelled by somebody, and is submitted again.
    farm.kill_at_first_checkpoint({1: NODE_FAILS, 2: int(signal.SIGTERM)})
    result = farm.submit(scene, "--samples", 6000, "--split", 4)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "part 2 has ended early and is submitted again" in result.stdout
    assert farm.runs().count("1 2") == 2 and len(farm.runs()) == 6
    assert np.array_equal(image(farm.job / "output" / "0001.exr"), whole(scene, tmp_path, 6000))
    header = read_header(farm.job / "merged" / "0001.checkpoint")
    assert header is not None and header.ranges == [(3, 0, 6000)]
    logs = "".join(path.read_text(errors="replace") for path in farm.state.glob("*/*.log"))
    assert "error" not in logs.lower()


def test_a_task_that_is_lost_for_ever_costs_only_its_samples(farm, scene):
    # It is killed in each of its attempts, but its checkpoint has a part of its samples.
    farm.kill_at_first_checkpoint({0: int(signal.SIGKILL)})
    result = farm.submit(scene, "--samples", 8000, "--split", 2, "--attempts", 1)
    assert result.returncode == 1 and "1 parts lack samples" in result.stdout, result.stdout
    header = read_header(farm.job / "merged" / "0001.checkpoint")
    assert header is not None and 4000 < header.samples < 8000 and len(header.ranges) == 2


def test_samples_are_added_until_the_merged_image_has_the_noise_that_was_asked_for(farm, scene):
    first = farm.submit(scene, "--samples", 8, "--split", 2)
    assert first.returncode == 0
    header = read_header(farm.job / "merged" / "0001.checkpoint")
    assert header is not None and header.relmse > 0
    farm.job = farm.folder / "target"
    result = farm.submit(scene, "--samples", 8, "--split", 2, "--error", header.relmse / 6)
    assert result.returncode == 0, result.stdout
    merged = read_header(farm.job / "merged" / "0001.checkpoint")
    assert merged is not None and 0 < merged.relmse <= header.relmse / 6 and merged.samples > 8
    job = Job.open(farm.job)
    assert len(job.waves()) >= 2
    ranges = sorted((task.first, task.first + task.samples) for wave in job.waves() for task in job.tasks(wave))
    assert ranges[0][0] == 0 and all(end == first for (_, end), (first, _) in zip(ranges, ranges[1:])), "the further samples are those that follow"
    # A later part may end before an earlier one. If the target is then reached, the earlier part is cancelled and its samples are missing in the merged image.
    for _, first, end in merged.ranges:
        assert first in {a for a, _ in ranges} and end in {b for _, b in ranges}


def test_tasks_are_cancelled_when_the_noise_target_is_met(farm, scene):
    farm.environment["FAKE_SLOTS"] = "1"
    result = farm.submit(scene, "--samples", 40000, "--split", 8, "--error", 1e3)
    assert result.returncode == 0
    assert (farm.state / "cancelled").exists() and len(farm.runs()) < 8


def test_most_samples_end_a_frame_that_does_not_reach_its_target(farm, scene):
    result = farm.submit(scene, "--samples", 4, "--split", 2, "--error", 1e-12, "--max-samples", 12)
    assert result.returncode == 1 and "less than was asked for" in result.stdout
    header = read_header(farm.job / "merged" / "0001.checkpoint")
    assert header is not None and header.samples == 12


def test_a_corrupt_checkpoint_one_of_another_version_and_one_of_other_settings_are_refused_and_rendered_again(farm, scene, tmp_path):
    assert farm.run(*farm.arguments(scene, "--samples", 40, "--split", 4, "--no-watch")).returncode == 0
    job = Job.open(farm.job)
    tasks = job.tasks(1)
    deadline = time.monotonic() + 60
    while not all(job.is_complete(task) for task in tasks):
        assert time.monotonic() < deadline
        time.sleep(0.1)
    other, corrupt, version, _ = (job.partial(1, task.part) for task in tasks)
    content = bytearray(corrupt.read_bytes())
    content[-1000] ^= 4
    corrupt.write_bytes(content)
    version.write_bytes(b"AJARCHP1" + version.read_bytes()[8:])
    other.unlink()
    subprocess.run([str(BUILD / "ajar-render"), str(scene), str(tmp_path / "other.exr"), "--continue", str(other), "--first-sample", "0", "--samples", "10", "--seed", "3",
                    "--clamp-indirect", "0.5", "--integrator", "path"], check=True, capture_output=True)
    result = farm.run("watch", farm.job)
    assert result.returncode == 0, result.stdout + result.stderr
    for words in ("checksum is wrong", "another version", "settings differ"):
        assert words in result.stdout, (words, result.stdout)
    assert np.array_equal(image(job.output(1)), whole(scene, tmp_path, 40))
    assert len(list(corrupt.parent.glob("*.refused"))) == 3


def test_two_submitters_on_one_folder(farm, scene, tmp_path):
    both = [farm.start(*farm.arguments(scene, "--samples", 40, "--split", 2)) for _ in range(2)]
    texts = [process.communicate(timeout=120)[0] for process in both]
    assert sorted(process.returncode for process in both) == [0, 2], texts
    assert any("watched already" in text for text in texts), texts
    assert len(farm.runs()) == 2 and np.array_equal(image(farm.job / "output" / "0001.exr"), whole(scene, tmp_path, 40))
    other = farm.submit(scene, "--samples", 80)
    assert other.returncode == 2 and "another job already" in other.stderr


def test_a_watcher_that_was_killed_leaves_a_lock_that_the_next_one_takes(farm, scene, tmp_path):
    watcher = farm.start(*farm.arguments(scene, "--samples", 900, "--split", 3))
    while not (farm.job / "waves" / "001.id").exists():
        time.sleep(0.02)
    watcher.kill()
    watcher.communicate()
    assert (farm.job / "lock").exists()
    result = farm.run("watch", farm.job)
    assert result.returncode == 0, result.stdout + result.stderr
    assert len(farm.runs()) == 3, "nothing is submitted twice"
    assert np.array_equal(image(farm.job / "output" / "0001.exr"), whole(scene, tmp_path, 900)) and not (farm.job / "lock").exists()


def test_a_full_disk_on_one_node(farm, scene, tmp_path):
    # A program in front of ajar-render that lets the first run of one part write 20 KB a file.
    program = tmp_path / "render"
    program.write_text(f"""#!/bin/bash
case "$*" in *00001.exr*) if mkdir {tmp_path}/full 2> /dev/null; then trap '' XFSZ; ulimit -f 20; fi;; esac
exec {BUILD}/ajar-render "$@"
""")
    program.chmod(0o755)
    arguments = farm.arguments(scene, "--samples", 40, "--split", 2)
    arguments[arguments.index("--render") + 1] = program
    result = farm.run(*arguments)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "part 1 has ended early" in result.stdout and (tmp_path / "full").exists()
    assert "could not be written: File too large" in "".join(path.read_text(errors="replace") for path in farm.state.glob("1/*.log"))
    assert np.array_equal(image(farm.job / "output" / "0001.exr"), whole(scene, tmp_path, 40))
    assert not list((farm.job / "partial").rglob("*.part-*"))


def test_frames_by_their_numbers(farm, scene, tmp_path):
    for frame in (3, 4):
        os.symlink(scene, tmp_path / f"shot_{frame:04}.ajar")
    (tmp_path / "shot_####.ajar").touch()
    result = farm.submit(tmp_path / "shot_####.ajar", "--frames", "3-4", "--samples", 8, "--split", 2)
    assert result.returncode == 0, result.stdout + result.stderr
    assert sorted(path.name for path in (farm.job / "output").iterdir()) == ["0003.exr", "0004.exr"]
    assert frames_of("1-7:3,9") == [1, 4, 7, 9]


def test_what_the_user_gets_wrong_is_said(farm, scene, tmp_path):
    for arguments, words in ((["submit", tmp_path / "none.ajar"], "There is no scene"), (["submit", scene, "--frames", "1-2"], "one frame"),
                             (["submit", scene, "--frames", "x"], "no list of frames"), (["watch", tmp_path], "no folder of a job"), (["submit", "a.txt"], "neither")):
        result = farm.run(*arguments)
        assert result.returncode == 2 and words in result.stderr, result.stderr


def test_the_script_can_be_read_and_run_by_hand(farm, scene):
    assert farm.submit(scene, "--samples", 8, "--split", 2, "--script-only", "--slurm=--mem=2G", "--", "--bounces-total", 3).returncode == 0
    text = (farm.job / "waves" / "001.sh").read_text()
    assert "#SBATCH --mem=2G" in text and "--bounces-total 3" in text and "#SBATCH --requeue" in text
    assert subprocess.run(["bash", "-n", str(farm.job / "waves" / "001.sh")], check=False).returncode == 0
    assert not (farm.state / "runs").exists()


def test_memory_of_a_merge_does_not_depend_on_the_number_of_parts(scene, tmp_path):
    def parts(count: int) -> list[str]:
        names = []
        for k in range(count):
            names.append(str(tmp_path / f"{k}.checkpoint"))
            if not Path(names[-1]).exists():
                subprocess.run([str(BUILD / "ajar-render"), str(scene), str(tmp_path / "x.exr"), "--continue", names[-1], "--first-sample", str(k), "--samples", "1", "--seed", "3",
                                "--width", "300", "--height", "300", "--region", "0", "0", "300", "300", "--integrator", "path", "--bounces-total", "0"], check=True, capture_output=True)
        return names

    def peak(count: int) -> int:
        child = subprocess.Popen([str(BUILD / "ajar-render"), "--merge", str(tmp_path / "m.exr"), str(tmp_path / "m"), *parts(count)], stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = status
        assert status == 0
        return usage.ru_maxrss
    few, many = peak(3), peak(9)
    assert many < 1.05 * few, (few, many)
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss > 0
