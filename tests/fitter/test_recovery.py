"""Fits of a few random materials per model (oracle: their parameters); `test_recovery_heavy.py` does many."""

import pytest
from recovery import EXACT, ONE_LOBE, recover


@pytest.mark.parametrize("model", ONE_LOBE)
def test_random_materials_are_recovered(model):
    for seed in range(3):
        assert recover(model, seed).found, seed


@pytest.mark.parametrize("model", ["ggx+ggx", "lambert+ggx+beckmann"])
def test_sums_of_random_lobes_are_recovered_in_cost(model):
    for seed in range(3):
        assert recover(model, seed).cost < EXACT, seed
