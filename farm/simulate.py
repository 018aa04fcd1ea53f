#!/usr/bin/env python3
"""What limits a farm of many nodes: a simulation with the rates of one measured node. Prints a table (docs/manual/farm.md has it).

Every node renders tasks of a frame and writes checkpoints to a shared file system; at the end all parts are merged, by one machine or by a tree of merges on the nodes.
Nodes differ in speed, some are much slower (stragglers), and some fail and lose what they have rendered since their last checkpoint.
"""
from __future__ import annotations

import argparse
import heapq
import random
from dataclasses import dataclass


@dataclass(frozen=True)
class Rates:
    """Of one node, measured (see farm.md), and of the shared file system, assumed."""

    megapixels: float = 2.07             # of the image
    samples_per_second: float = 1.0      # of the whole image, on a node of 32 cores
    start_seconds: float = 10.0          # the scheduler, the program, reading and building the scene
    bytes_per_megapixel: float = 96e6    # of a checkpoint with Combined
    merge_seconds: float = 0.4           # for a megapixel of a part
    disk: float = 2e9                    # bytes per second of the shared file system, all nodes together
    scene_bytes: float = 500e6
    interval: float = 300.0              # seconds between two checkpoints
    spread: float = 0.1                  # standard deviation of the speed of nodes
    stragglers: float = 0.01             # share of nodes that are slower,
    slowness: float = 4.0                # so many times
    failures: float = 1.0 / (30 * 86400)    # of a node, per second
    submit_rate: float = 100.0           # tasks that the scheduler starts per second


@dataclass
class Outcome:
    seconds: float
    read: float
    rendering: float
    merging: float
    disk_share: float


def simulate(nodes: int, samples: int, rates: Rates, parts_per_node: int, tree: int, seed: int) -> Outcome:
    chance = random.Random(seed)
    part = rates.bytes_per_megapixel * rates.megapixels
    tasks = nodes * parts_per_node
    work = samples / tasks / rates.samples_per_second
    # All nodes read the scene at the beginning.
    read = nodes * rates.scene_bytes / rates.disk
    speeds = [max(0.2, chance.gauss(1.0, rates.spread)) / (rates.slowness if chance.random() < rates.stragglers else 1.0) for _ in range(nodes)]
    free = [(index / rates.submit_rate + read, index) for index in range(nodes)]
    heapq.heapify(free)
    ends: list[float] = []
    writes = 0.0
    for _ in range(tasks):
        at, node = heapq.heappop(free)
        at += rates.start_seconds
        left = work / speeds[node]
        # A failure costs half a checkpoint interval and a new start.
        while (until := chance.expovariate(rates.failures)) < left:
            at += until + min(until, 0.5 * rates.interval) + 2 * rates.start_seconds
            left -= max(0.0, until - 0.5 * rates.interval)
        at += left
        writes += part * (1 + left // rates.interval)
        ends.append(at)
        heapq.heappush(free, (at, node))
    ends.sort()
    one = rates.merge_seconds * rates.megapixels
    if tree <= 1:
        done = 0.0
        for end in ends:    # one machine merges parts as they arrive
            done = max(done, end) + max(one, part / rates.disk)
    else:
        # Each merge of `tree` parts runs on a node; levels follow each other.
        level, done, count = tree * max(one, part / rates.disk), ends[-1], tasks
        while count > 1:
            merges = -(-count // tree)
            # All merges of a level share the file system.
            done += max(level, count * part / rates.disk)
            count = merges
    ideal = ends[-1] - read
    return Outcome(done, read, ideal, done - ends[-1], writes / rates.disk / max(1e-9, ideal))


def table(rates: Rates, hours: float, seeds: int) -> str:
    lines = ["| nodes | parts a node | merge | reading scenes s | rendering s | merging after it s | all s | efficiency | file system in use |", "|---|---|---|---|---|---|---|---|---|"]
    samples = int(hours * 3600 * rates.samples_per_second)
    for nodes in (100, 1000, 10000):
        for parts, tree in ((1, 1), (8, 1), (8, 16)):
            runs = [simulate(nodes, samples, rates, parts, tree, seed) for seed in range(seeds)]
            mean = [sum(getattr(run, name) for run in runs) / seeds for name in ("read", "rendering", "merging", "seconds", "disk_share")]
            efficiency = samples / rates.samples_per_second / nodes / mean[3]
            lines.append(f"| {nodes} | {parts} | {'one machine' if tree == 1 else f'tree of {tree}'} | {mean[0]:.0f} | {mean[1]:.0f} | {mean[2]:.0f} | {mean[3]:.0f} | "
                         f"{100 * efficiency:.0f} % | {100 * min(1.0, mean[4]):.0f} % |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=10000.0, help="work of the frame on one node")
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args()
    print(table(Rates(), given.hours, given.seeds))


if __name__ == "__main__":
    main()
