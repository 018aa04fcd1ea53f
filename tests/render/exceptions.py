"""The known differences between images of Ajar and Cycles, each with its reason. Every other difference is a bug.

Each scene has a list of exceptions. An exception applies to the blocks for which `covers(row, column)` is true, in a grid of 16 x 16-pixel blocks at
the size of the reference, rows from the top.
"""

from dataclasses import dataclass
from collections.abc import Callable


@dataclass(frozen=True)
class ExpectedDifference:
    reason: str
    covers: Callable[[int, int], bool] = lambda row, column: True


EXPECTED_DIFFERENCES: dict[str, list[ExpectedDifference]] = {}


def unexpected(scene_name: str, found: list) -> list:
    """The differences that no exception covers."""
    expected = EXPECTED_DIFFERENCES.get(scene_name, [])
    return [d for d in found if not any(difference.covers(d.row, d.column) for difference in expected)]
