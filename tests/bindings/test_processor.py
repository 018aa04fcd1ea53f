"""Tests of the choice of the compiled module by the processor."""

from __future__ import annotations

import sys

import pytest
from ajar import processor, system

V2, V3 = "x86-64-v2", "x86-64-v3"
OLD = processor.LEVELS[V2] | {"fpu", "sse2"}                  # a processor of 2010
NEW = OLD | processor.LEVELS[V3] | {"avx512f"}


def test_the_highest_supported_level_is_chosen():
    assert processor.choose({V2, V3}, NEW) == V3
    assert processor.choose({V2, V3}, OLD) == V2
    assert processor.choose({V2}, NEW) == V2
    assert processor.choose({V2, V3}, NEW - {"movbe"}) == V2


def test_a_requested_level_is_used_or_raises_an_error():
    assert processor.choose({V2, V3}, NEW, V2) == V2
    with pytest.raises(ImportError, match="this processor runs x86-64-v2"):
        processor.choose({V2, V3}, OLD, V3)
    with pytest.raises(ImportError, match="x86-64-v4"):
        processor.choose({V2, V3}, NEW, "x86-64-v4")


def test_error_on_an_old_processor_names_the_missing_instructions():
    with pytest.raises(ImportError, match="lacks sse4_2"):
        processor.choose({V2, V3}, OLD - {"sse4_2"})


def test_this_processor_has_the_level_of_the_module():
    assert processor.LEVELS[V2] <= system.processor_flags()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows tells the flags itself")
def test_flags_are_read_from_the_kernel_s_list(tmp_path):
    text = tmp_path / "cpuinfo"
    text.write_text("processor\t: 0\nmodel name\t: x\nflags\t\t: fpu sse2 lahf_lm\n\nprocessor\t: 1\nflags\t\t: fpu\n")
    assert system.processor_flags(text) == {"fpu", "sse2", "lahf_lm"}


def test_a_build_for_one_machine_has_one_module(tmp_path):
    assert processor.folder_of(tmp_path) == tmp_path
