"""The layered models: against a table, against transcriptions of their specifications, and in their limits."""

import dataclasses
import math

import cases
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from plain_layered import plain_fresnel, plain_gltf, plain_openpbr

from brdf import MODELS, evaluate
from brdf.distributions import d_gtr, gtr_norm
from brdf.frame import geometry
from brdf.fresnel import f_dielectric
from brdf.integrate import albedo
from brdf.layering import (
    dielectric_albedo,
    dielectric_transmission,
    f0_of_ior,
    f_dielectric_f0,
    mean_dielectric,
    t_dielectric_f0,
)
from brdf.models.disney import d_berry
from brdf.sheen import charlie_albedo, d_charlie, fuzz, fuzz_albedo, v_charlie

Disney, GLTF, OpenPBR = (MODELS[name] for name in ("disney", "gltf", "openpbr"))
WHITE, BLACK = np.ones(3), np.zeros(3)


def with_values(model, **values):
    return dataclasses.replace(model, **{name: np.float64(value) for name, value in values.items()})


def random_pairs(seed, count=2000):
    """Directions anywhere, as far as 1e-3 from the horizon, and their normalised half vector."""
    rng = np.random.default_rng(seed)
    cosine, phi = rng.uniform(1e-3, 1, (2, count)), rng.uniform(-np.pi, np.pi, (2, count))
    sine = np.sqrt(1 - cosine * cosine)
    wi, wo = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)
    h = wi + wo
    return wi, wo, h / np.linalg.norm(h, axis=1, keepdims=True)


# ---- Disney ----


def test_disney_equals_brdf_explorer(shared):
    file = np.load(shared / "oracle" / "disney.npz")

    def value(p, wi, wo):
        names = ("metallic", "subsurface", "specular", "roughness", "specular_tint", "anisotropic", "sheen")
        names = (*names, "sheen_tint", "clearcoat", "clearcoat_gloss")
        values = dict(zip(names, p[3:], strict=True))
        # The shader decodes its base colour by the power 2.2; here it is linear.
        return Disney(base_color=p[:3] ** 2.2, **values)(wi, wo)

    found = np.asarray(jax.jit(jax.vmap(value))(file["params"], file["wi"], file["wo"]))
    # The shader starts from a rounded n . h, of which the clearcoat's slope of 0.001 loses the last 7 digits.
    np.testing.assert_allclose(found, file["value"], rtol=1e-9)


def test_disney_clearcoat_is_the_general_distribution_at_gamma_1():
    wi, wo, _ = random_pairs(1, 300)
    for alpha in (0.1, 0.03, 0.001):
        a = jnp.asarray(alpha)
        ours = jax.vmap(lambda i, o, a=a: d_berry(geometry(i, o), a))(wi, wo)
        norm = gtr_norm(a * a, jnp.ones_like(a))
        general = jax.vmap(lambda i, o, a=a, norm=norm: d_gtr(geometry(i, o), a, a, jnp.ones_like(a), norm))(wi, wo)
        np.testing.assert_allclose(ours, general, rtol=1e-9)


def test_disney_with_course_notes_masks_more_at_low_roughness_and_alike_at_1():
    # Oracle: (0.5 + r / 2)^2 is r^2 at r = 1 and larger below, and a larger slope masks more.
    wi, wo, _ = random_pairs(2, 500)
    bare = with_values(Disney(base_color=BLACK), specular=1, roughness=0.3)
    notes = dataclasses.replace(bare, masking_remap="course_notes")
    assert (np.asarray(evaluate(notes, wi, wo)) < np.asarray(evaluate(bare, wi, wo))).all()
    rough, rough_notes = (with_values(model, roughness=1) for model in (bare, notes))
    np.testing.assert_allclose(evaluate(rough, wi, wo), evaluate(rough_notes, wi, wo), rtol=1e-12)


def test_disney_tints_of_a_black_base_are_white():
    wi, wo, _ = random_pairs(3, 200)
    black = with_values(Disney(base_color=BLACK), sheen=1, specular=1, sheen_tint=1, specular_tint=1)
    untinted = with_values(black, sheen_tint=0, specular_tint=0)
    np.testing.assert_allclose(evaluate(black, wi, wo), evaluate(untinted, wi, wo), rtol=1e-14)


# ---- glTF ----


def test_gltf_equals_its_specification():
    wi, wo, h = random_pairs(5)
    for model in cases.models("gltf", 6, 8):
        rough = {
            name: max(float(getattr(model, name)), 0.3)
            for name in ("roughness", "clearcoat_roughness", "sheen_roughness")
        }
        model = with_values(model, **rough)
        # The transcription's 1 - (n . h)^2 loses digits, which the exponent of up to 11 multiplies.
        np.testing.assert_allclose(evaluate(model, wi, wo), plain_gltf(model, wi, wo, h), rtol=1e-9)


def test_gltf_without_specular_and_layers_is_lambert():
    wi, wo, _ = random_pairs(7, 200)
    model = with_values(GLTF(base_color=np.array([0.2, 0.5, 0.9])), metallic=0, specular=0)
    np.testing.assert_array_equal(evaluate(model, wi, wo), np.broadcast_to(model.base_color / math.pi, wi.shape))


def test_gltf_is_reciprocal_without_a_clearcoat_only():
    wi, wo, _ = random_pairs(8, 500)
    model = with_values(cases.models("gltf", 9, 2)[1], clearcoat=0, roughness=0.4)
    np.testing.assert_allclose(evaluate(model, wi, wo), evaluate(model, wo, wi), rtol=1e-9)
    coated = with_values(model, clearcoat=1)
    assert not np.allclose(evaluate(coated, wi, wo), evaluate(coated, wo, wi), rtol=1e-2)
    assert not coated.claims().reciprocal


# ---- OpenPBR ----


def test_openpbr_equals_its_specification():
    wi, wo, h = random_pairs(10)
    for model in cases.models("openpbr", 11, 10):
        names = ("specular_roughness", "coat_roughness", "fuzz_roughness")
        model = with_values(
            model,
            **{name: max(float(getattr(model, name)), 0.2) for name in names},
            coat_ior=max(float(model.coat_ior), 1.05),
            specular_roughness_anisotropy=min(float(model.specular_roughness_anisotropy), 0.9),
        )
        # Where the metal's tint brings it close to zero, and a coat's K close to 1, the transcription cancels.
        np.testing.assert_allclose(evaluate(model, wi, wo), plain_openpbr(model, wi, wo, h), rtol=1e-7, atol=1e-10)


def test_openpbr_sends_the_viewer_no_more_light_than_there_is():
    # Oracle: quadrature, which resolves roughnesses from 0.42; the albedos' fits let 1.3 % too much pass.
    for model in cases.models("openpbr", 12, 12):
        rough = {name: max(float(getattr(model, name)), 0.42) for name in ("specular_roughness", "coat_roughness")}
        model = with_values(
            dataclasses.replace(model, base_color=WHITE, specular_color=WHITE, coat_color=WHITE, fuzz_color=WHITE),
            **rough,
            specular_roughness_anisotropy=min(float(model.specular_roughness_anisotropy), 0.6),
        )
        for theta in (0.0, 0.7, 1.2, 1.5):
            assert albedo(model, theta, 96).max() <= 1.015


def test_a_white_glossy_openpbr_loses_only_what_its_facets_lose():
    model = with_values(OpenPBR(base_color=WHITE), specular_roughness=0.5, base_diffuse_roughness=0.5)
    for theta in (0.0, 0.7, 1.2):
        np.testing.assert_allclose(albedo(model, theta, 96), 1, atol=0.012)


def test_openpbr_metal_is_reciprocal_and_its_layers_are_not():
    wi, wo, _ = random_pairs(13, 500)
    metal = with_values(OpenPBR(base_color=np.array([0.9, 0.6, 0.3])), base_metalness=1)
    np.testing.assert_allclose(evaluate(metal, wi, wo), evaluate(metal, wo, wi), rtol=1e-9)
    assert not metal.claims().reciprocal
    for layer in ({"base_metalness": 0}, {"coat_weight": 1}, {"fuzz_weight": 1}):
        layered = with_values(metal, **layer)
        assert not np.allclose(evaluate(layered, wi, wo), evaluate(layered, wo, wi), rtol=1e-2)


def test_a_boundary_of_no_reflectance_has_its_true_slope_in_specular_weight():
    # Oracle: a one-sided difference, where the root of the weight in the index would give infinity or zero.
    wi, wo = jnp.array([0.6, 0.0, 0.8]), jnp.array([-0.5, 0.1, math.sqrt(0.74)])

    def value(weight):
        return OpenPBR(specular_weight=weight)(wi, wo)[0]

    slope = (value(jnp.asarray(1e-6)) - value(jnp.asarray(0.0))) / 1e-6
    # The next term goes with the root of the weight, 1e-3.
    np.testing.assert_allclose(jax.jit(jax.grad(value))(jnp.asarray(0.0)), slope, rtol=2e-2)


# ---- limits of all three ----

ABSENT = [
    ("disney", {"clearcoat": 0}, {"clearcoat_gloss": 0.2}),
    ("disney", {"sheen": 0}, {"sheen_tint": 0.9}),
    ("disney", {"metallic": 1}, {"specular": 0.9, "subsurface": 0.9, "sheen": 0.9, "specular_tint": 0.9}),
    ("disney", {"anisotropic": 0}, {"rotation": 0.7}),
    ("gltf", {"clearcoat": 0}, {"clearcoat_roughness": 0.3}),
    ("gltf", {"metallic": 1}, {"specular": 0.3, "ior": 2.2}),
    ("gltf", {"anisotropy_strength": 0}, {"anisotropy_rotation": 0.7}),
    ("openpbr", {"coat_weight": 0}, {"coat_roughness": 0.9, "coat_ior": 2.2, "coat_darkening": 0.1}),
    ("openpbr", {"fuzz_weight": 0}, {"fuzz_roughness": 0.9}),
    ("openpbr", {"base_metalness": 1}, {"base_diffuse_roughness": 0.9, "specular_ior": 2.2}),
    ("openpbr", {"specular_roughness_anisotropy": 0}, {"rotation": 0.7}),
]


@pytest.mark.parametrize(("name", "limit", "ineffective"), ABSENT)
def test_what_is_absent_has_no_effect(name, limit, ineffective):
    wi, wo, _ = random_pairs(14, 500)
    values = {"roughness": 0.4, "specular_roughness": 0.4, "metallic": 0.3, "base_metalness": 0.3, "coat_weight": 0.0}
    start = {key: value for key, value in values.items() if hasattr(MODELS[name], key)}
    model = with_values(MODELS[name](base_color=np.array([0.3, 0.6, 0.9])), **(start | limit))
    changed = with_values(model, **ineffective)
    np.testing.assert_allclose(evaluate(model, wi, wo), evaluate(changed, wi, wo), rtol=1e-12)
    # The same parameters do have an effect away from the limit.
    back = dict.fromkeys(limit, 0.5)
    with_both = np.asarray(evaluate(with_values(model, **back), wi, wo))
    assert not np.allclose(with_both, evaluate(with_values(changed, **back), wi, wo), rtol=1e-6)


def test_sheen_and_fuzz_of_no_strength_leave_the_base_alone():
    wi, wo, _ = random_pairs(15, 500)
    for model, other in (
        (GLTF(sheen_color=BLACK), {"sheen_roughness": 0.6}),
        (with_values(OpenPBR(fuzz_color=WHITE), fuzz_weight=0), {"fuzz_roughness": 0.1}),
    ):
        np.testing.assert_array_equal(evaluate(model, wi, wo), evaluate(with_values(model, **other), wi, wo))


# ---- the parts ----


def test_the_boundary_by_its_reflectance_equals_the_one_by_its_index():
    cosine = np.concatenate([np.linspace(0.01, 1, 100), [1e-6]])
    for ior in (1.001, 1.05, 1.5, 3.0):
        f0 = f0_of_ior(jnp.asarray(ior))
        f = jax.vmap(f_dielectric_f0, (None, 0))(f0, cosine)
        np.testing.assert_allclose(
            f, jax.vmap(f_dielectric, (None, 0))(jnp.asarray(ior), cosine), rtol=1e-9, atol=1e-18
        )
        np.testing.assert_allclose(jax.vmap(t_dielectric_f0, (None, 0))(f0, cosine), 1 - f, rtol=1e-9, atol=1e-15)
    for f0 in (0.0, 1e-12, 1e-8):
        total = f_dielectric_f0(jnp.asarray(f0), jnp.asarray(0.3)) + t_dielectric_f0(jnp.asarray(f0), jnp.asarray(0.3))
        np.testing.assert_allclose(total, 1, rtol=1e-14)
    assert f_dielectric_f0(jnp.asarray(0.0), jnp.asarray(1e-9)) == 0


@pytest.mark.parametrize("ior", [1.05, 1.5, 3.0])
def test_the_albedo_of_a_rough_boundary_is_near_its_quadrature(ior):
    ggx = dataclasses.replace(MODELS["ggx"](), fresnel="dielectric", ior=np.float64(ior))
    for alpha in (0.2, 0.5, 1.0):
        for cosine in (0.1, 0.3, 0.6, 1.0):
            truth = albedo(with_values(ggx, alpha=alpha), math.acos(cosine), 96)[0]
            f0, c, a = (jnp.asarray(x) for x in (((ior - 1) / (ior + 1)) ** 2, cosine, alpha))
            fit = dielectric_albedo(f0, c, a)
            assert abs(float(fit) - truth) <= 0.021
            np.testing.assert_allclose(dielectric_transmission(f0, c, a), 1 - fit, rtol=1e-12)


def test_the_mean_reflectance_of_a_boundary_is_near_its_quadrature():
    x, weight = np.polynomial.legendre.leggauss(400)
    cosine = (0.5 * (1 + x)) ** 2
    for ior in (1.0, 1.01, 1.1, 1.5, 2.2, 3.0):
        truth = float(np.sum(weight * (1 + x) * cosine * plain_fresnel(ior, cosine)))
        assert abs(float(mean_dielectric(jnp.asarray(ior))) - truth) <= 4e-4


def _lobe_albedo(lobe, cosine, nodes=400):
    """Quadrature with nodes that crowd at the horizon, where sheen lies."""
    x, weight = np.polynomial.legendre.leggauss(nodes)
    u = 0.5 * (1 + x)
    cos_i, weight = u**3, 0.5 * weight * 3 * u**2
    phi = (np.arange(nodes) + 0.5) * (np.pi / nodes)
    sine = np.sqrt(1 - cos_i**2)
    wi = np.stack([np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(cos_i, np.ones(nodes))], axis=-1)
    wo = np.broadcast_to([math.sqrt(1 - cosine**2), 0, cosine], wi.reshape(-1, 3).shape)
    value = np.asarray(jax.jit(jax.vmap(lambda i, o: lobe(geometry(i, o))))(wi.reshape(-1, 3), wo)).reshape(
        nodes, nodes
    )
    return float(np.sum(value * (cos_i * weight)[:, None]) * (2 * np.pi / nodes))


@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.6, 1.0])
def test_the_albedos_of_sheen_and_fuzz_are_near_their_quadratures(roughness):
    r = jnp.asarray(roughness)
    for cosine in (0.03, 0.2, 0.5, 0.9):
        charlie = _lobe_albedo(lambda g: d_charlie(g, r) * v_charlie(g, r), cosine)
        assert abs(float(charlie_albedo(jnp.asarray(cosine), r)) - min(charlie, 1)) <= 0.022
        # A linearly transformed cosine is a density: the albedo is exact.
        np.testing.assert_allclose(
            _lobe_albedo(lambda g: fuzz(g, r), cosine), fuzz_albedo(jnp.asarray(cosine), r), rtol=1e-6
        )


@pytest.mark.parametrize("name", ["disney", "gltf", "openpbr"])
def test_proposals_cover_what_the_models_reflect(name):
    # Oracle: value * cosine / density is bounded wherever the mixture covers; a missing part would let it grow as the
    # value at grazing angles and in the tails does.
    wi, wo = cases.pairs(16, 4000)
    # Below it the visibility of a lobe is all of the value.
    keep = (wi[:, 2] > 1e-2) & (wo[:, 2] > 1e-2)
    wi, wo = wi[keep], wo[keep]
    for model in cases.models(name, 17, 8):
        pdf = np.asarray(jax.jit(jax.vmap(model.pdf))(wi, wo))
        weight = np.asarray(evaluate(model, wi, wo)).mean(axis=1) * wi[:, 2]
        assert np.isfinite(pdf).all()
        assert (pdf[weight > 0] > 0).all()
        # Fuzz of a small roughness, seen at a grazing angle, is the narrowest that is left to the cosine: 123.
        assert (weight <= 200 * pdf).all()
