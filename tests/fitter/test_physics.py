"""The laws, looked up for one set of parameters."""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

from brdf.integrate import albedo
from brdf.material import from_dict
from brdf.model import AbstractBRDF
from brdf.registry import MODELS
from brdf.sampling import Proposals
from fitter.physics import ENERGY_TOLERANCE, check


def material(model: str, **parameters):
    return from_dict({"model": model, "parameters": parameters}).brdf


class Lopsided(AbstractBRDF):
    """Breaks reciprocity by a known amount."""

    tilt: float = eqx.field(static=True)

    def reflect(self, g):
        return jnp.ones(3) * 0.2 * (1 + self.tilt * g.cos_i)

    def proposals(self, cos_o):
        return Proposals(jnp.ones_like(cos_o), ())


def test_a_matte_surface_reflects_its_albedo():
    # Oracle: Lambert.
    found = check(material("lambert", lambert={"albedo": [0.2, 0.87, 0.3]}))
    np.testing.assert_allclose(found.albedo_max, 0.87, rtol=1e-6)
    assert (found.channel, found.theta_deg, found.asymmetry) == ("green", 0, 0)
    assert found.sentence() == "reflects at most 0.87 of the light (at 0 degrees, green); reciprocal"
    assert check(material("lambert", lambert={"albedo": 1.0})).keeps_energy


@pytest.mark.parametrize("alpha", [1e-4, 1e-3, 0.03])
def test_the_narrowest_highlight_over_a_bright_base_gains_energy(alpha):
    # Oracle: the albedos of both lobes add up; a polished lobe's is Schlick's reflectance at the mirror angle.
    found = check(material("lambert+ggx", lambert={"albedo": 0.9}, ggx={"alpha": alpha, "f0": 0.5}))
    at_80 = 0.9 + 0.5 + 0.5 * (1 - np.cos(np.radians(80))) ** 5
    np.testing.assert_allclose(found.albedo_max_to_80, at_80, rtol=5e-4 if alpha < 0.01 else 0.02)
    assert not found.keeps_energy
    assert found.sentence().startswith(f"gains energy: {found.albedo_max:.4g} of the light at")
    assert "none up to 80" not in found.sentence()


def test_a_gain_at_grazing_angles_alone_is_said_to_be_there():
    # Oracle: Schlick's reflectance passes 0.2 between 80 and 88 degrees only.
    found = check(material("lambert+ggx", lambert={"albedo": 0.5}, ggx={"alpha": 0.001, "f0": 0.04}))
    assert not found.keeps_energy
    assert found.albedo_max_to_80 < 1
    assert "though none up to 80 degrees" in found.sentence()


@pytest.mark.parametrize("name", [name for name in MODELS if MODELS[name]().claims().reciprocal])
def test_models_keep_at_their_defaults_what_they_claim(name):
    # Oracle: the model's claim, and the albedo by an independent rule, good to 3e-4 at the default slopes.
    model = MODELS[name]()
    found = check(model)
    assert found.is_reciprocal
    assert found.albedo_max <= model.claims().albedo_max * (1 + ENERGY_TOLERANCE)
    there = albedo(model, np.radians(found.theta_deg), nodes=256).max()
    np.testing.assert_allclose(found.albedo_max, there, rtol=ENERGY_TOLERANCE)


def test_a_lobe_with_a_direction_of_its_own_is_looked_at_from_all_sides():
    # Oracle: the isotropic lobe of either slope; across its brush a lobe reflects more at grazing angles than along.
    shape = {"anisotropy": "anisotropic", "f0": 0.9}
    there = [check(material("ggx", ggx={"alpha_x": a, "alpha_y": b, **shape})) for a, b in ((0.02, 0.5), (0.5, 0.02))]
    np.testing.assert_allclose(there[0].albedo_max, there[1].albedo_max, rtol=1e-3)


def test_a_model_that_is_not_reciprocal_is_found_out():
    # Oracle: its formula at the pair with the largest difference in cosine.
    found = check(Lopsided(0.5))
    assert not found.is_reciprocal
    np.testing.assert_allclose(found.asymmetry, 1 - 1 / 1.5, atol=0.03)
    assert "not reciprocal: exchanging light and viewer changes it by up to 3" in found.sentence()
    assert found.to_dict()["is_reciprocal"] is False


def test_a_black_material_is_physical():
    # Oracle: nothing is reflected, which is no division by zero.
    found = check(material("lambert", lambert={"albedo": 0.0}))
    assert found.albedo_max == 0
    assert found.keeps_energy
    assert found.is_reciprocal
