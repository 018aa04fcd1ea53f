"""The benchmark page has the measured values."""

import math
import xml.etree.ElementTree

import numpy as np
import plots
import pytest
import report


def result(factor=2.0, repeats=2):
    """Results in which Ajar is `factor` times as fast as Cycles and the errors are 1 / time."""
    runs = []
    for repeat in range(1, repeats + 1):
        for samples in (1, 4, 16):
            for technique, seconds in ((report.OURS, samples / factor), (report.THEIRS, float(samples))):
                runs.append({"technique": technique, "repeat": repeat, "samples": samples, "seed": repeat, "seconds": seconds,
                             "relmse": 1.0 / samples, "relmse_trimmed": 0.5 / samples, "path": "", "statistics": {"rays_per_second": 3e6, "scene": {"triangles": 2_000_000}}})
    return {"scene": "box", "width": 192, "height": 144, "runs": runs, "bare_embree": {"share_of_bare": 0.55},
            "mean_ratio": [1.002, 0.004], "export": {"export_seconds": 0.5}}


def test_speedup_and_its_spread():
    assert report.speedup_with_spread(result()) == pytest.approx((2.0, 2.0, 2.0))
    assert report.speedup(result(), error="relmse_trimmed") == pytest.approx(2.0)


def test_error_at_equal_time_is_interpolated_on_the_curve():
    curve = report.curves_of(result())[report.OURS]
    assert report.error_after(curve, 1.0) == pytest.approx(0.5)
    assert math.isnan(report.error_after(curve, 1000.0))


def test_page_has_a_row_for_each_scene_and_lists_failures(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "strip_of", lambda found, work: np.zeros((4, 4, 3), np.uint8))
    monkeypatch.setattr(report, "write_jpegs", lambda pngs: None)
    results = {"machine": {"threads": "2"}, "full": False, "repeats": 2, "longest_render": 3.0, "reference_seconds": 12.0,
               "scenes": [result(), {"scene": "room", "failure": "ajar-render ended with code 1"}]}
    report.write_page(results, tmp_path, tmp_path)
    page = (tmp_path / "index.md").read_text()
    assert "**Median speed-up at equal relMSE: 2.00**" in page
    assert "| box | 192×144 | 8.00 | 0.0625 | 0.125 | 16 | 0.0625 | 0.0625 | **2.00** (2.00 to 2.00) | 2.00 | 1.0020 ± 0.0040 |" in page
    assert "| box | 2,000,000 (0) | 0.50 | 0.25 | – | 3.00 | 55% | – | – |" in page
    assert "room: ajar-render ended with code 1" in page


def test_plots_are_well_formed_and_ticks_are_round():
    svg = plots.loglog_plot("a < b", {"Ajar & co": ([1, 10], [0.1, 0.01]), "Cycles": ([2, 20], [0.1, 0.01])})
    assert xml.etree.ElementTree.fromstring(svg).tag.endswith("svg")
    assert plots.decades(0.5, 200.0) == [1.0, 10.0, 100.0]
    assert plots.decades(1.5, 7.0) == [2.0, 5.0]
