"""Where Ajar and Cycles are known not to show the same image, each with its reason. Anything else that differs is a bug.

A scene maps to a list of exceptions; each covers the blocks for which `covers(row, column)` is true, in a grid of 16 x 16-pixel
blocks at the reference's size, rows from the top.
"""

from dataclasses import dataclass
from collections.abc import Callable


@dataclass(frozen=True)
class ExpectedDifference:
    reason: str
    covers: Callable[[int, int], bool] = lambda row, column: True


EXPECTED_DIFFERENCES: dict[str, list[ExpectedDifference]] = {}


def unexpected(scene_name: str, found: list) -> list:
    """The disagreements that no exception covers."""
    expected = EXPECTED_DIFFERENCES.get(scene_name, [])
    return [d for d in found if not any(difference.covers(d.row, d.column) for difference in expected)]
