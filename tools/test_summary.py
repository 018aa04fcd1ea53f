"""test_summary.py RESULTS.xml ...: prints the counts of the tests of all JUnit files. The exit code is 1 if a test failed or a file is missing."""

import argparse
import sys
import xml.etree.ElementTree as xml
from pathlib import Path


def count(path: Path) -> tuple[int, int, int]:
    """(passed, failed, skipped) of one file. A program that ended before it wrote its file counts as one failure."""
    if not path.exists():
        print(f"{path.name}: no results; the program ended early.")
        return 0, 1, 0
    passed = failed = skipped = 0
    for case in xml.parse(path).getroot().iter("testcase"):
        if case.find("failure") is not None or case.find("error") is not None:
            failed += 1
            print(f"FAILED {case.get('classname')}.{case.get('name')}")
        elif case.find("skipped") is not None or case.get("result") == "skipped":
            skipped += 1
        else:
            passed += 1
    return passed, failed, skipped


def main(paths: list[Path]) -> int:
    passed, failed, skipped = (sum(column) for column in zip(*(count(path) for path in paths)))
    print(f"{passed} passed, {failed} failed, {skipped} skipped")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, nargs="+", help="JUnit files")
    sys.exit(main(parser.parse_args().results))
