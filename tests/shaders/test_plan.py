"""The frame plan: only what leads to an output is run. Oracle: the definition, on small graphs."""

from __future__ import annotations

import pytest

from shaders.plan import Pass, plan


def _pass(name: str, reads: str, writes: str, enabled: bool = True, side_effect: bool = False) -> Pass:
    return Pass(name, frozenset(reads.split()), frozenset(writes.split()), enabled, side_effect)


def test_a_chain_to_the_output_is_kept_in_order():
    made = plan([_pass("a", "", "x"), _pass("b", "x", "y"), _pass("c", "y", "z")], ["z"])
    assert [one.name for one in made.passes] == ["a", "b", "c"]
    assert made.dropped == {}


def test_a_pass_that_nobody_reads_is_dropped_with_all_that_only_it_needed():
    made = plan([_pass("a", "", "x"), _pass("blur", "x", "blurred"), _pass("glow", "blurred", "glowing")], ["x"])
    assert [one.name for one in made.passes] == ["a"]
    assert made.dropped == {"blur": "not read", "glow": "not read"}


def test_a_disabled_pass_is_dropped_and_what_only_it_read_too():
    made = plan([_pass("a", "", "x"), _pass("b", "", "y"), _pass("c", "y", "x", enabled=False)], ["x"])
    assert [one.name for one in made.passes] == ["a"]
    assert made.dropped == {"b": "not read", "c": "disabled"}


def test_all_passes_that_write_a_picture_are_kept():
    made = plan([_pass("mesh", "", "frame"), _pass("sky", "", "frame"), _pass("end", "frame", "out")], ["out"])
    assert [one.name for one in made.passes] == ["mesh", "sky", "end"]


def test_a_side_effect_keeps_a_pass_that_nobody_reads():
    made = plan([_pass("a", "", "x"), _pass("dump", "x", "", side_effect=True), _pass("b", "", "y")], ["y"])
    assert [one.name for one in made.passes] == ["a", "dump", "b"]


def test_a_read_that_nothing_writes_is_an_error_that_names_both():
    with pytest.raises(ValueError, match="`b` reads `x`"):
        plan([_pass("a", "", "x", enabled=False), _pass("b", "x", "y")], ["y"])


def test_a_read_before_its_write_is_an_error():
    with pytest.raises(ValueError, match="`b` reads `x`"):
        plan([_pass("b", "x", "y"), _pass("a", "", "x")], ["x", "y"])


def test_an_output_that_nothing_writes_is_an_error():
    with pytest.raises(ValueError, match="output `z`"):
        plan([_pass("a", "", "x")], ["z"])
