"""Attributes of curves and point clouds as arrays."""

from __future__ import annotations

import bpy
import numpy as np

from .. import compat
from ..ajar_module import ajar

CURVE_NORMAL = ".curve_normal"   # the normals of hair curves, for materials that ask for them

_DOMAINS = {"POINT": ajar.Domain.Vertex, "CURVE": ajar.Domain.Face}
_VALUES = {  # data type of an attribute -> RNA name of its value, components, kind
    "FLOAT": ("value", 1, np.float32), "INT": ("value", 1, np.int32), "INT8": ("value", 1, np.int32), "BOOLEAN": ("value", 1, bool),
    "FLOAT2": ("vector", 2, np.float32), "FLOAT_VECTOR": ("vector", 3, np.float32), "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
}


def read(attribute: bpy.types.Attribute) -> np.ndarray:
    """The values: one number or row for each element of the domain."""
    value, components, kind = _VALUES[attribute.data_type]
    return compat.numbers(attribute.data, value, components, kind)


def named(data: bpy.types.Curves | bpy.types.PointCloud, names: set[str]) -> list[tuple]:
    """(name, domain, values) of each attribute of these names that materials can use."""
    found = [data.attributes[name] for name in sorted(names) if name in data.attributes]
    return [(attribute.name, _DOMAINS[attribute.domain], read(attribute).astype(np.float32, copy=False).reshape(-1, _VALUES[attribute.data_type][1]))
            for attribute in found if attribute.data_type in _VALUES and attribute.domain in _DOMAINS]
