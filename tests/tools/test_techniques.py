"""The page of techniques has the results of the runs."""

import techniques


def result(factor=8.0):
    runs = []
    for repeat in (1, 2, 3):
        for name, relmse in ((techniques.CYCLES, 0.8), ("metropolis", 0.8 / factor)):
            runs.append({"technique": name, "repeat": repeat, "seconds": 1.0, "cpu_seconds": 2.0, "samples": 4, "path": "", "relmse": relmse * (1 + 0.1 * repeat),
                         "trimmed": relmse / 2, "mean": 1.0 + 0.01 * repeat, "refused": 0})
    return {"scene": "room", "width": 192, "height": 144, "runs": runs, "failures": {"auto": "not built yet"}, "reference_noise": 1e-4,
            "reference_check": 1.001}


def test_efficiency_is_relative_to_that_of_cycles():
    row = techniques.technique_row(result(), "metropolis")
    assert "**8** " in row and "1.0200 ± 0.0058" in row
    assert techniques.technique_row(result(), "erpt") is None


def test_an_error_below_the_noise_of_the_reference_has_no_efficiency():
    found = result()
    for run in found["runs"]:
        if run["technique"] == "metropolis":
            run["relmse"] = -1e-5
    assert techniques.efficiencies(found, "metropolis", "relmse") == []
    assert "–" in techniques.technique_row(found, "metropolis")


def test_page_lists_techniques_that_were_not_measured():
    text = techniques.page({"machine": {"threads": "2"}, "seconds": 3.0, "repeats": 3, "scenes": [result()]})
    assert "auto was not measured: not built yet" in text
    assert text.count("| metropolis |") == 1 and "1.0010 of its mean" in text


def test_every_technique_has_an_integrator():
    assert all("--integrator" in options for options in techniques.AJAR_TECHNIQUES.values())
