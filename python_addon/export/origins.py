"""Data that instances have from the instancers that placed them: coordinates for From Instancer, and particles for Particle Info.

They are read only if a material uses them, since this takes time for each instance.
"""

from __future__ import annotations

from array import array

import bpy
import numpy as np

from .context import ExportContext

COLUMNS = 18   # of SceneDescription.set_origins
NO_PARTICLE = (0.0,) * 13


class Origins:
    """One row for each instance that has an instancer. The class has no references to evaluated data, so that a viewport can keep it."""

    def __init__(self) -> None:
        self.instances = array("i")
        self.values = array("f")

    def add(self, number: int, instance: bpy.types.DepsgraphObjectInstance, frame: float) -> None:
        self.instances.append(number)
        # Cycles halves Blender's coordinates and subtracts a half.
        self.values.extend(0.5 * x - 0.5 for x in instance.orco)
        self.values.extend(instance.uv)
        self.values.extend(_particle(instance, frame))

    def export(self, context: ExportContext, shown: np.ndarray) -> None:
        """`shown`: a flag for each instance; the others are not in the description."""
        if not self.instances:
            return
        numbers = np.frombuffer(self.instances, dtype=np.int32)
        kept = shown[numbers]
        values = np.frombuffer(self.values, dtype=np.float32).reshape(-1, COLUMNS)
        context.description.set_origins((np.cumsum(shown) - 1)[numbers[kept]].astype(np.int32), values[kept])


def _particle(instance: bpy.types.DepsgraphObjectInstance, frame: float) -> tuple[float, ...]:
    """The last 13 columns. As in Cycles, children of particles have no data."""
    system = instance.particle_system
    if system is None:
        return NO_PARTICLE
    index = instance.persistent_id[0]
    if not 0 <= index < len(system.particles):
        return NO_PARTICLE
    particle = system.particles[index]
    return (index, frame - particle.birth_time, particle.lifetime, particle.size, *particle.location, *particle.velocity, *particle.angular_velocity)
