"""Tests of Blender with a window, on a virtual display with OpenGL in software: the rendered view and edits in it.

`AJAR_EDITS=200` sets the number of random edits of the last test, `AJAR_SEED` their seed.
"""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from blender_process import BUILD, TIMEOUT_SECONDS, environment
from PIL import Image

sys.path.insert(0, str(BUILD / "python"))
import ajar

SCENE = os.path.join(os.path.dirname(__file__), "..", "..", "test_scenes", "box.blend")
CHECKER = os.path.join(os.path.dirname(__file__), "..", "..", "test_scenes", "checker.blend")   # adaptive sampling clearly pays there
STAND_IN = BUILD / "tests" / "core" / "ajar_stand_in_denoiser.so"   # for Open Image Denoise
WINDOW = os.path.join(os.path.dirname(__file__), "window")
pytestmark = pytest.mark.skipif(shutil.which("Xvfb") is None, reason="needs Xvfb (tools/setup.sh test)")


@pytest.fixture(scope="module")
def edited(profile, display, tmp_path_factory):
    """The result of `window/edits.py`, and the folder of its images."""
    assert STAND_IN.exists(), f"{STAND_IN} is not built: without it, the view has nothing to denoise with"
    folder = tmp_path_factory.mktemp("window")
    arguments = ["--python", f"{WINDOW}/drive.py", "--", f"{WINDOW}/edits.py", folder / "result.json", folder,
                 os.environ.get("AJAR_EDITS", "20"), os.environ.get("AJAR_SEED", "1")]
    result = subprocess.run(
        [os.environ.get("BLENDER", "blender"), "--factory-startup", "--enable-event-simulate", "--window-geometry", "0", "0", "960", "600",
         "--addons", "ajar_render",
         *map(str, arguments)],
        env=environment(profile) | {"DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1", "AJAR_DENOISER": str(STAND_IN)}, text=True, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, timeout=TIMEOUT_SECONDS * (1 + int(os.environ.get("AJAR_EDITS", "20")) // 100), check=False)
    assert result.returncode == 0, f"exit code {result.returncode}\n{result.stdout}"
    values = json.loads((folder / "result.json").read_text())
    return values, folder, result.stdout


@pytest.fixture(scope="module")
def day(profile, display, tmp_path_factory):
    """The result of `window/day.py`."""
    folder = tmp_path_factory.mktemp("day")
    result = subprocess.run(
        [os.environ.get("BLENDER", "blender"), "--factory-startup", "--window-geometry", "0", "0", "960", "600", "--addons", "ajar_render", "--python", f"{WINDOW}/drive.py", "--",
         f"{WINDOW}/day.py", folder / "result.json", folder, SCENE],
        env=environment(profile) | {"DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=2 * TIMEOUT_SECONDS, check=False)
    assert result.returncode == 0, f"exit code {result.returncode}\n{result.stdout}"
    return json.loads((folder / "result.json").read_text()), folder, result.stdout


@pytest.fixture(scope="module")
def progress(profile, display, tmp_path_factory):
    """The result of `window/progress.py` for a render by F12, and the folder of its images."""
    folder = tmp_path_factory.mktemp("progress")
    result = subprocess.run(
        [os.environ.get("BLENDER", "blender"), "--factory-startup", "--enable-event-simulate", "--window-geometry", "0", "0", "960", "600", "--addons", "ajar_render",
         "--python", f"{WINDOW}/drive.py", "--", f"{WINDOW}/progress.py", folder / "result.json", folder, CHECKER],
        env=environment(profile) | {"DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=2 * TIMEOUT_SECONDS, check=False)
    assert result.returncode == 0, f"exit code {result.returncode}\n{result.stdout}"
    return json.loads((folder / "result.json").read_text()), folder, result.stdout


def test_the_graph_of_the_noise_is_updated_during_a_render_and_kept_after_it(progress):
    values, folder, words = progress
    assert values["shown_at_first"] == 0 and not values["idle"]["is_noted"] and "Traceback" not in words
    first, during, later, after = (values[name] for name in ("without_density", "during", "later", "after"))
    assert first["is_running"] and during["is_running"] and later["is_running"] and not after["is_running"]
    assert 0 < first["points"] < during["points"] < later["points"] < after["points"]
    pictures = [seen["pictures"]["noise IMAGE_EDITOR"] for seen in (first, during, later, after)]
    assert len({picture["sum"] for picture in pictures}) == 4   # all are different
    assert all(picture["size"][0] > 90 and picture["colours"] > 10 for picture in pictures)
    assert not values["redrawn_when_idle"]
    # On the screen, only the curve is orange.
    for name in ("during", "after"):
        screen = np.asarray(Image.open(folder / f"{name}.png").convert("RGB")).astype(int)
        red, green, blue = screen[..., 0], screen[..., 1], screen[..., 2]
        curve = (red > 200) & (np.abs(green - 0.65 * red) < 20) & (blue < 0.45 * red)
        assert curve.sum() > 30 and np.ptp(np.flatnonzero(curve.any(axis=0))) > 20, name


def test_the_map_of_the_samples_is_drawn_when_it_is_switched_on(progress):
    values, _, _ = progress
    assert values["without_density"]["density"] is None and list(values["without_density"]["pictures"]) == ["noise IMAGE_EDITOR"]
    for name in ("during", "later", "after"):
        least, mean, most, height, width = values[name]["density"]
        assert 0 < least <= mean <= most and (height, width) == (120, 160), name   # equal in all pixels until the estimate of the noise is reliable
        assert mean <= values[name]["samples"] <= 640, name
        assert values[name]["pictures"]["density IMAGE_EDITOR"]["size"] == [160, 120], name
    least, mean, most, _, _ = values["after"]["density"]
    assert least < mean < most and values["after"]["pictures"]["density IMAGE_EDITOR"]["colours"] > 1
    assert values["during"]["density"][1] < values["later"]["density"][1] < values["after"]["density"][1] == 640


def test_a_rendered_view_shows_its_samples_without_rendering_again(progress):
    view = progress[0]["view"]
    assert view["changed"] > 0.05 and view["left_over"] < 1e-3 and view["renders"] == 0, view


def test_daily_work_needs_no_other_engine(day):
    values, folder, words = day
    assert values["engine"] == "AJAR" and len(values["edited"]) == 4 and "Traceback" not in words
    assert {"mesh MATERIAL", "mesh WORLD", "mesh VIEW_LAYER", "light DATA", "camera DATA", "hint OBJECT"} <= set(values["tabs"])
    assert values["hint_status"][-1].startswith("Attached"), values
    assert values["runs_while_paused"] in (True, None) and values["statistics"]["state"] == "done"
    picture = ajar.read_image(str(folder / "picture.png"))
    assert picture.shape[:2] == (200, 320) and picture[..., :3].std() > 0.01
    assert (folder / "saved.blend").exists()


def test_the_screen_shows_the_image_of_the_renderer_with_blenders_view_transform(edited):
    values, folder, _ = edited
    screen, picture = ajar.read_image(str(folder / "view.png")), np.load(folder / "view.npy")[..., :3]
    x, y, width, height = values["region"]
    assert picture.shape[:2] == (height, width)
    screen = screen[y:y + height, x:x + width, :3]
    seen = picture.clip(0, 1)  # the same range as the linear values that read_image computes from the screen
    free = np.ones((height, width), bool)  # pixels without tools and headers over the view
    for left, bottom, across, up in values["overlapping"]:
        free[max(0, bottom - y):max(0, bottom - y + up), max(0, left - x):max(0, left - x + across)] = False
    free[-80:] = False  # text
    assert seen[free].std() > 0.05
    # One step of the 8 bits of the screen is at most 2.4 / 255 in linear values.
    difference = np.abs(screen - seen)[free]
    assert np.median(difference) < 1 / 255 and np.mean(difference > 5 / 255) < 0.01


def test_each_edit_exports_and_builds_only_what_it_changed(edited):
    counters = edited[0]["counters"]
    for name in ("turn", "select"):
        assert counters[name]["updates"] == 0, name
    for name in ("transform", "colour", "energy", "world"):
        assert counters[name] == {"exported": 0, "updates": 1, "walks": 0, "built": 0, "placed": int(name == "transform"),
                                  "compiled": int(name == "colour")}, name
    assert counters["geometry"]["exported"] == counters["geometry"]["built"] == 1


def test_another_exposure_of_the_display_renders_nothing(edited):
    assert edited[0]["renders_for_exposure"] == 0


def test_a_light_hint_is_drawn_by_clicks_on_surfaces(edited):
    drawn = edited[0]["drawn"]
    lamp, floor, cube = drawn["points"]
    assert drawn["starts_at"] == "Light" and lamp == pytest.approx(drawn["lamp"], abs=1e-5)
    assert floor == pytest.approx([2.5, -2.5, -1], abs=0.05) and cube == pytest.approx([0, -1, 0], abs=0.05)
    assert drawn["status"].startswith("Attached"), drawn


def test_photons_are_drawn_as_points_on_surfaces_while_switched_on(edited):
    photons = edited[0]["photons"]
    assert photons["unasked"] == 0
    assert 1000 < photons["shown"] <= min(photons["stored"], 50_000) and photons["lowest"] == pytest.approx(-1, abs=1e-4)
    assert photons["red_pixels"] > 1000, photons   # the photons of red light
    assert photons["left_over"] == 0, photons


def test_a_denoised_view_shows_the_denoised_image_of_the_last_sample(edited):
    denoised = edited[0]["denoise"]
    assert denoised["available"] and denoised["unasked"] < 0.1, denoised
    assert denoised["last"] == [denoised["render"], denoised["render"], 1, 8] and denoised["samples"] == 8, denoised
    assert denoised["blue"] > 0.8, denoised


def test_a_denoised_view_follows_a_turn_and_shows_no_picture_of_an_earlier_render(edited):
    denoised = edited[0]["denoise"]
    assert denoised["moves"] > 1 and len({picture[0] for picture in denoised["moved"]}) > 1, denoised   # pictures appear while it turns
    assert all(picture[0] == picture[1] for picture in denoised["pictures"]), denoised
    assert denoised["moved"][-1][0] == denoised["moved_render"] and denoised["moved"][-1][2:] == [1, 8], denoised
    assert denoised["moved_blue"] > 0.8, denoised


def test_a_denoised_view_shows_its_samples_without_rendering_again(edited):
    denoised = edited[0]["denoise"]
    assert denoised["density_blue"] < 0.1 and denoised["image_blue"] > 0.8 and denoised["renders"] == 0, denoised


def test_switching_off_the_denoiser_shows_the_rendered_image(edited):
    assert edited[0]["denoise"]["off_blue"] < 0.1, edited[0]["denoise"]


def test_the_view_says_that_the_library_is_missing(edited):
    denoised = edited[0]["denoise"]
    assert "Not denoised: no library" in denoised["without_library"] and "Not denoised" not in denoised["status"], denoised
    assert denoised["renders_without_library"] == 0, denoised


def test_random_edits_end_with_an_image(edited):
    values, _, words = edited
    mean, deviation, samples = values["end"]
    assert mean > 0.01 and deviation > 0.01 and samples >= 1, values
    assert values["revisions"]["edits"] >= 4 and values["revisions"]["differences"] == 0, values
    assert "Traceback" not in words, words
