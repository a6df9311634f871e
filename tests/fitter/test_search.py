"""The search over static choices. Oracle: the declarations."""

import pytest

import brdf
from brdf.errors import UserError
from brdf.parameter import choices
from brdf.registry import expression_of, split
from fitter.search import searched


def options(model, name):
    return next(choice.options for choice in choices(brdf.build(model)) if choice.name == name)


def test_every_combination_comes_once():
    found = searched("lambert+ggx", ("masking", " energy"))
    pairs = {(split(one)["ggx"].masking, split(one)["ggx"].energy) for one in found}
    assert len(found) == len(pairs) == len(options("ggx", "masking")) * len(options("ggx", "energy"))
    assert {expression_of(one) for one in found} == {"lambert+ggx"}


def test_lobes_share_a_choice_and_one_that_knows_fewer_options_keeps_its_own():
    wide, narrow = options("ggx", "fresnel"), options("cook_torrance", "fresnel")
    assert set(narrow) < set(wide)
    for expression in ("ggx+cook_torrance", "cook_torrance+ggx"):
        found = [split(one) for one in searched(expression, ("fresnel",))]
        assert {lobes["ggx"].fresnel for lobes in found} == set(wide)
        for lobes in found:
            own = lobes["ggx"].fresnel if lobes["ggx"].fresnel in narrow else narrow[0]
            assert lobes["cook_torrance"].fresnel == own


def test_a_choice_named_twice_is_searched_once():
    assert len(searched("ggx", ("energy", "energy"))) == len(options("ggx", "energy"))


def test_unknown_choices_and_too_many_combinations_are_refused():
    with pytest.raises(UserError, match="Did you mean `masking`"):
        searched("lambert+ggx", ("maskin",))
    with pytest.raises(UserError, match=r"more than 64[.] Search fewer"):
        searched("ggx", ("masking", "fresnel", "anisotropy", "energy"))
