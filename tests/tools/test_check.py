import check


def test_more_work_than_recorded_is_found_and_new_scenes_are_not_tested():
    assert check.verdicts({"a": 104.0, "b": 106.0, "c": 5.0, "d": 50.0}, {"a": 100.0, "b": 100.0, "d": 100.0}) == [
        ("a", 1.04, True), ("b", 1.06, False), ("d", 0.5, True)]
