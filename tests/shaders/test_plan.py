"""The frame plan: only what leads to an output and is new is run. Oracle: the definition, on small graphs."""

from __future__ import annotations

import pytest

from shaders.plan import Pass, Version, plan


def _pass(
    name: str,
    reads: str,
    writes: str,
    key: int = 0,
    enabled: bool = True,
    side_effect: bool = False,
    every_frame: bool = False,
) -> Pass:
    return Pass(name, frozenset(reads.split()), frozenset(writes.split()), key, enabled, side_effect, every_frame)


def test_a_chain_to_the_output_is_kept_in_order():
    made = plan([_pass("a", "", "x"), _pass("b", "x", "y"), _pass("c", "y", "z")], ["z"], {})
    assert [one.name for one in made.passes] == ["a", "b", "c"]
    assert made.dropped == {}


def test_a_pass_that_nobody_reads_is_dropped_with_all_that_only_it_needed():
    made = plan([_pass("a", "", "x"), _pass("blur", "x", "blurred"), _pass("glow", "blurred", "glowing")], ["x"], {})
    assert [one.name for one in made.passes] == ["a"]
    assert made.dropped == {"blur": "not read", "glow": "not read"}


def test_a_disabled_pass_is_dropped_and_what_only_it_read_too():
    made = plan([_pass("a", "", "x"), _pass("b", "", "y"), _pass("c", "y", "x", enabled=False)], ["x"], {})
    assert [one.name for one in made.passes] == ["a"]
    assert made.dropped == {"b": "not read", "c": "disabled"}


def test_all_passes_that_write_a_picture_are_kept():
    made = plan([_pass("mesh", "", "frame"), _pass("sky", "", "frame"), _pass("end", "frame", "out")], ["out"], {})
    assert [one.name for one in made.passes] == ["mesh", "sky", "end"]


def test_a_side_effect_keeps_a_pass_that_nobody_reads():
    made = plan([_pass("a", "", "x"), _pass("dump", "x", "", side_effect=True), _pass("b", "", "y")], ["y"], {})
    assert [one.name for one in made.passes] == ["a", "dump", "b"]


def test_a_read_that_nothing_writes_is_an_error_that_names_both():
    with pytest.raises(ValueError, match="`b` reads `x`"):
        plan([_pass("a", "", "x", enabled=False), _pass("b", "x", "y")], ["y"], {})


def test_a_read_before_its_write_is_an_error():
    with pytest.raises(ValueError, match="`b` reads `x`"):
        plan([_pass("b", "x", "y"), _pass("a", "", "x")], ["x", "y"], {})


def test_an_output_that_nothing_writes_is_an_error():
    with pytest.raises(ValueError, match="output `z`"):
        plan([_pass("a", "", "x")], ["z"], {})


def _chain(sky: int = 0, mesh: int = 0, tone: int = 0) -> list[Pass]:
    """The sky's table and the mesh lead to a picture, the picture to the output."""
    return [
        _pass("table", "", "lights", sky),
        _pass("mesh", "lights", "picture", mesh),
        _pass("tone", "picture", "out", tone),
    ]


def _statuses(passes: list[Pass], kept: dict[str, Version]) -> tuple[list[str], tuple[str, ...], dict[str, str]]:
    made = plan(passes, ["out"], kept)
    return [one.name for one in made.passes], made.reused, made.dropped


def test_nothing_is_run_when_the_output_is_kept_in_the_same_version():
    kept = plan(_chain(), ["out"], {}).versions
    above = "its reader is reused"
    assert _statuses(_chain(), kept) == ([], ("tone",), {"table": above, "mesh": above})


def test_what_a_new_key_changes_is_run_and_what_comes_before_it_is_reused():
    kept = plan(_chain(), ["out"], {}).versions
    assert _statuses(_chain(tone=1), kept) == (["tone"], ("mesh",), {"table": "its reader is reused"})
    assert _statuses(_chain(mesh=1), kept) == (["mesh", "tone"], ("table",), {})
    assert _statuses(_chain(sky=1), kept) == (["table", "mesh", "tone"], (), {})


def test_a_kept_resource_that_is_gone_is_made_again_only_if_it_is_read():
    kept = plan(_chain(), ["out"], {}).versions
    gone = {name: version for name, version in kept.items() if name == "picture"}
    assert _statuses(_chain(), gone) == (["tone"], ("mesh",), {"table": "its reader is reused"})


def test_all_writers_of_a_resource_run_again_when_one_of_them_has_changed():
    def drawn(sky: int) -> list[Pass]:
        return [_pass("mesh", "", "frame"), _pass("sky", "", "frame", sky), _pass("tone", "frame", "out")]

    kept = plan(drawn(0), ["out"], {}).versions
    assert _statuses(drawn(1), kept) == (["mesh", "sky", "tone"], (), {})


def test_a_side_effect_happens_although_its_result_is_kept():
    passes = [*_chain(), _pass("count", "picture", "", side_effect=True)]
    kept = plan(passes, ["out"], {}).versions
    assert _statuses(passes, kept) == (["count"], ("mesh", "tone"), {"table": "its reader is reused"})


def test_what_jittered_frames_hand_to_each_other_is_never_taken_for_kept():
    def summed(count: int) -> list[Pass]:
        return [
            _pass("mesh", "", "frame", every_frame=True),
            _pass("add", "frame", "out", count, every_frame=True),
        ]

    kept = plan(summed(1), ["out"], {}).versions
    assert _statuses(summed(1), kept)[0] == []
    assert _statuses(summed(2), kept)[0] == ["mesh", "add"]


def test_a_pass_that_is_turned_off_changes_the_version_of_what_it_wrote():
    on = [_pass("mesh", "", "frame"), _pass("sky", "", "frame"), _pass("tone", "frame", "out")]
    off = [_pass("mesh", "", "frame"), _pass("sky", "", "frame", enabled=False), _pass("tone", "frame", "out")]
    assert _statuses(off, plan(on, ["out"], {}).versions) == (["mesh", "tone"], (), {"sky": "disabled"})
