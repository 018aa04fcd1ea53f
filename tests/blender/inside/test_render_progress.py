"""Tests of the data of a render that the Progress panel shows."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from ajar_render import graph, render_progress
from ajar_render.ajar_module import ajar
from ajar_render.ui import progress


@pytest.fixture
def noted_scene(build, scene):
    build.object(build.mesh())
    build.object(bpy.data.lights.new("Lamp", "POINT"), "Lamp", (0.5, 0.5, 1.0))
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 24, 16, 100
    scene.ajar.samples, scene.ajar.integrator = 16, "path"
    render_progress._noted.clear()
    yield scene
    render_progress._noted.clear()
    render_progress._areas.clear()
    render_progress._density_is_shown = False


@pytest.fixture
def session(noted_scene, export):
    session = ajar.Session()
    description = export()
    description.settings.image, description.settings.samples = "pmc_ip", 32
    session.start(description)
    assert session.wait(300.0) and session.take_error() == ""
    return session


class Layout:
    """Records what a panel draws."""

    def __init__(self):
        self.labels, self.properties, self.icons = [], [], []

    def label(self, text="", **_):
        self.labels.append(text)

    def prop(self, _data, name, **_):
        self.properties.append(name)

    def template_icon(self, icon_value, scale):
        self.icons.append((icon_value, scale))

    def column(self, **_):
        return self

    row = column


class Area:
    type = "IMAGE_EDITOR"

    def as_pointer(self):
        return 1


class Context:
    preferences = bpy.context.preferences

    def __init__(self, scene, width):
        self.scene, self.area, self.region = scene, Area(), type("Region", (), {"width": width})


def drawn(scene, width=300):
    layout = Layout()
    progress._Progress.draw(type("Panel", (), {"layout": layout, "_draw_density": progress._Progress._draw_density})(), Context(scene, width))
    return layout


def test_nothing_is_recorded_in_the_background(noted_scene):
    bpy.ops.render.render()
    assert bpy.app.background and render_progress.of(noted_scene) is None
    layout = drawn(noted_scene)
    assert layout.properties == ["show_sample_density"] and layout.icons == [] and layout.labels == ["Shown from the next render on"]
    assert render_progress._areas == {} and not bpy.app.timers.is_registered(render_progress._look)


def test_a_record_has_the_values_of_the_session(session, noted_scene):
    render_progress._note(noted_scene.name, session, 1e-4, False)
    noted = render_progress.of(noted_scene)
    errors = session.error_over_time()
    assert errors.shape[1] == 4 and errors[-1, 1] == noted.samples == 32 and noted.target == pytest.approx(0.01)
    assert len(noted.seconds) == len(noted.noise) == (errors[:, 1] > 2).sum() > 2
    np.testing.assert_allclose(noted.noise**2, errors[errors[:, 1] > 2, 2])
    assert (np.diff(noted.seconds) > 0).all() and noted.density is None and not noted.is_running


def test_sample_counts_are_recorded_only_while_the_map_is_shown(session, noted_scene):
    render_progress._areas[1] = 0
    render_progress._note(noted_scene.name, session, 0.0, True)
    assert render_progress.of(noted_scene).density is None
    render_progress._density_is_shown = True
    render_progress._note(noted_scene.name, session, 0.0, True)
    density = render_progress.of(noted_scene).density
    counts = session.snapshot("Sample Count")[..., 0]
    assert density.means.shape == (16, 24) and density.mean == pytest.approx(32)
    assert (density.least, density.most) == (counts.min(), counts.max()) and density.least < density.most
    render_progress._areas.clear()
    render_progress._note(noted_scene.name, session, 0.0, True)
    assert render_progress.of(noted_scene).density is None


def test_noise_is_shown_in_percent_without_powers_of_ten():
    assert [render_progress.noise_words(noise, 0.0) for noise in (0.0123, 0.5, 0.994, 1.1, 12.5)] == ["1.2 %", "50 %", "99 %", "110 %", "1250 %"]
    assert render_progress.noise_words(1.1, 0.02) == "110 % of 2 %"


@pytest.mark.parametrize("width, pictures", [(180, 2), (900, 2)])
def test_the_panel_shows_the_record(session, noted_scene, width, pictures):
    noted_scene.ajar.show_sample_density = True
    render_progress._areas[1], render_progress._density_is_shown = 0, True
    render_progress._note(noted_scene.name, session, 1e-4, False)
    layout = drawn(noted_scene, width)
    assert len(layout.icons) == pictures and list(progress._pictures["density IMAGE_EDITOR"].image_size) == [24, 16]
    assert layout.icons[0][1] * progress.ICON_UNIT <= width
    assert layout.labels[0] == "32 samples" and layout.labels[1].endswith(" of 1 %") and any(text.endswith(" per pixel") for text in layout.labels)
    preview = progress._pictures["noise IMAGE_EDITOR"]
    assert preview.image_size[0] == preview.image_size[1] == round(layout.icons[0][1] * progress.ICON_UNIT) - 2 * progress.ICON_PADDING
    picture = np.array(preview.image_pixels_float[:]).reshape(*preview.image_size, 4)
    assert (np.abs(picture[..., :3] - np.array(graph.CURVE)).max(axis=2) < 0.02).any()
    key = progress._drawn["noise IMAGE_EDITOR"]
    drawn(noted_scene, width)
    assert progress._drawn["noise IMAGE_EDITOR"] is key   # it is not drawn again


def test_times_are_shown_in_hours_minutes_and_seconds():
    assert [render_progress.clock(seconds) for seconds in (0.4, 59.6, 3599.4, 3600, 36125)] == ["00:00", "01:00", "59:59", "1:00:00", "10:02:05"]
    assert render_progress.noise_words(0.0123, 0.01) == "1.2 % of 1 %" and render_progress.noise_words(0.0123, 0.0) == "1.2 %"
