"""Point clouds: objects of this type, and points that geometry nodes make."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from . import attributes

if TYPE_CHECKING:
    from .context import ExportContext

EMPTY_RADIUS = 0.01   # for points without a radius, as in Cycles


def of_cloud(context: ExportContext, cloud: bpy.types.PointCloud, name: str) -> dict | None:
    """The arguments of `ajar.make_points`, or None if there are no points."""
    position = cloud.attributes.get("position")
    if position is None or len(position.data) == 0:
        return None
    positions = attributes.read(position)
    radius = cloud.attributes.get("radius")
    has_radius = radius is not None and radius.data_type == "FLOAT" and len(radius.data) == len(positions)
    radii = attributes.read(radius) if has_radius else np.full(len(positions), EMPTY_RADIUS, dtype=np.float32)
    context.check_cancelled()
    return {"name": name, "positions": positions, "radii": radii, "attributes": attributes.named(cloud, context.attribute_names)}
