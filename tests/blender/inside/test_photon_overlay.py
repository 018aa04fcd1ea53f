"""Tests of the photons of a render that are kept for the 3D view."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from ajar_render import last_render, photon_overlay


@pytest.fixture
def lit_corner(build, scene):
    build.object(build.mesh())
    build.object(build.mesh("Wall", [(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)]))
    lamp = build.object(bpy.data.lights.new("Lamp", "POINT"), "Lamp", (0.5, 0.5, 1.0))
    lamp.data.color = (1.0, 0.5, 0.25)
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.ajar.samples, scene.ajar.photons = 2, 60_000
    return scene


@pytest.mark.parametrize("integrator", sorted(photon_overlay.INTEGRATORS))
def test_photons_of_the_last_pass_are_kept_with_the_setting(lit_corner, integrator):
    lit_corner.ajar.integrator = integrator
    bpy.ops.render.render()
    assert photon_overlay.of(lit_corner) is None and photon_overlay.status_of(lit_corner) == "Shown after the next render"
    lit_corner.ajar.show_photons = True
    bpy.ops.render.render()
    photons = photon_overlay.of(lit_corner)
    extra = last_render.of(lit_corner)
    assert photons.stored == extra.get("chain_photons", extra["photons"] + extra["caustic_photons"]) > 0
    assert 0 < len(photons.positions) <= min(photon_overlay.MAX_PHOTONS, photons.stored)
    np.testing.assert_allclose(photons.positions[:, [0, 2]].min(axis=1), 0.0, atol=1e-5)
    assert (photons.positions > -1e-5).all() and (photons.positions < 1 + 1e-5).all()
    # The photons have the colour of the lamp, because the square is grey.
    assert (photons.colors[:, 0] > photons.colors[:, 1]).all() and (photons.colors[:, 1] > photons.colors[:, 2]).all()
    lit_corner.ajar.show_photons = False
    assert photon_overlay.of(lit_corner) is None


def test_an_integrator_without_photons_keeps_none(lit_corner):
    lit_corner.ajar.show_photons, lit_corner.ajar.integrator = True, "photon_map"
    bpy.ops.render.render()
    assert photon_overlay.of(lit_corner) is not None
    lit_corner.ajar.integrator = "path"
    bpy.ops.render.render()
    assert photon_overlay.of(lit_corner) is None


def test_colours_show_hue_and_power_and_no_photon_is_invisible():
    powers = np.array([[2, 1, 0]] * 40 + [[0, 0, 1e-6], [1000, 1000, 1000]], dtype=np.float32)
    colors = photon_overlay._colors(powers)
    np.testing.assert_allclose(colors[0], [1, np.sqrt(0.5), 0, 1], rtol=1e-6)
    np.testing.assert_allclose(colors[-2], [0, 0, photon_overlay.FAINTEST, 1], rtol=1e-6)
    np.testing.assert_allclose(colors[-1], 1)
    assert photon_overlay._colors(np.empty((0, 3), np.float32)).shape == (0, 4)
