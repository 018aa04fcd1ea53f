"""Data that instances have from the instancers that placed them: coordinates for From Instancer, and particles for Particle Info.

They are read only if a material uses them, since this takes time for each instance.
"""

from __future__ import annotations

import bpy
import numpy as np

from .context import ExportContext
from .instance_rows import InstanceRows

COLUMNS = 18   # of SceneDescription.set_origins
NO_PARTICLE = (0.0,) * 13


class Origins(InstanceRows):
    """One row for each instance that has an instancer."""

    def add(self, number: int, instance: bpy.types.DepsgraphObjectInstance, frame: float) -> None:
        # Cycles halves Blender's coordinates and subtracts a half.
        self.add_row(number, (*(0.5 * x - 0.5 for x in instance.orco), *instance.uv, *_particle(instance, frame)))

    def export(self, context: ExportContext, shown: np.ndarray) -> None:
        if (found := self.of_shown(shown, COLUMNS)) is not None:
            context.description.set_origins(*found)


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
