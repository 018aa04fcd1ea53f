"""Rows of numbers that some of the instances have."""

from __future__ import annotations

from array import array
from collections.abc import Iterable

import numpy as np


class InstanceRows:
    """One row for each of these instances, in growing arrays. The class has no references to evaluated data, so that a viewport can keep it."""

    def __init__(self) -> None:
        self.instances = array("i")
        self.values = array("f")

    def add_row(self, number: int, row: Iterable[float]) -> None:
        self.instances.append(number)
        self.values.extend(row)

    def of_shown(self, shown: np.ndarray, columns: int) -> tuple[np.ndarray, np.ndarray] | None:
        """The numbers of these instances in the description, and their rows; None: there are none. `shown`: a flag for each instance; the others are
        not in the description."""
        if not self.instances:
            return None
        numbers = np.frombuffer(self.instances, dtype=np.int32)
        kept = shown[numbers]
        rows = np.frombuffer(self.values, dtype=np.float32).reshape(-1, columns)
        return (np.cumsum(shown) - 1)[numbers[kept]].astype(np.int32), rows[kept]
