"""Models against Mitsuba 3, an independent renderer, where it is installed (`pip install mitsuba`)."""

import cases
import numpy as np
import pytest

from brdf import MODELS, evaluate

mi = pytest.importorskip("mitsuba", reason="Mitsuba 3 is an extra of the tests: pip install mitsuba")


@pytest.fixture(scope="module")
def directions():
    rng = np.random.default_rng(61)
    wi, wo = (cases.directions(rng, 600) for _ in range(2))
    keep = (wi[:, 2] > 0.05) & (wo[:, 2] > 0.05)
    near = wi * [-1, -1, 1] + 0.1 * rng.normal(size=wi.shape)
    near[:, 2] = np.abs(near[:, 2]) + 0.05
    wo = np.where((np.arange(len(wo)) % 2 == 0)[:, None], near / np.linalg.norm(near, axis=1, keepdims=True), wo)
    return wi[keep], wo[keep]


def reflected(description, wi, wo):
    """Mitsuba's value in 1/sr without the cosine; its `wo` is the light, its `wi` the viewer."""
    mi.set_variant("scalar_rgb")
    bsdf, context = mi.load_dict(description), mi.BSDFContext()
    values = []
    for light, viewer in zip(wi, wo, strict=True):
        si = mi.SurfaceInteraction3f()
        si.wi = mi.Vector3f(*map(float, viewer))
        values.append(np.array(bsdf.eval(context, si, mi.Vector3f(*map(float, light)))) / light[2])
    return np.array(values)


@pytest.mark.parametrize("name", ["ggx", "beckmann"])
@pytest.mark.parametrize("slopes", [(0.1, 0.1), (0.35, 0.35), (0.15, 0.6)])
def test_rough_conductors_agree(name, slopes, directions):
    wi, wo = directions
    eta, k = np.array([0.2, 0.9, 1.4]), np.array([3.9, 2.5, 1.8])
    description = {
        "type": "roughconductor",
        "distribution": name,
        "alpha_u": slopes[0],
        "alpha_v": slopes[1],
        "eta": {"type": "rgb", "value": eta.tolist()},
        "k": {"type": "rgb", "value": k.tolist()},
    }
    model = MODELS[name](
        alpha_x=slopes[0],
        alpha_y=slopes[1],
        eta=eta,
        k=k,
        anisotropy="anisotropic",
        fresnel="conductor",
        masking="smith_separable",
    )
    ours, theirs = np.asarray(evaluate(model, wi, wo)), reflected(description, wi, wo)
    # Mitsuba computes in float32 from a rounded n.h; its Beckmann masking is a rational approximation, good to 0.4 %.
    tolerance = {"ggx": 3e-4, "beckmann": 8e-3}[name]
    np.testing.assert_allclose(ours, theirs, rtol=tolerance, atol=1e-4)


def test_diffuse_agrees(directions):
    wi, wo = directions
    albedo = np.array([0.2, 0.5, 0.8])
    theirs = reflected({"type": "diffuse", "reflectance": {"type": "rgb", "value": albedo.tolist()}}, wi, wo)
    np.testing.assert_allclose(np.asarray(evaluate(MODELS["lambert"](albedo=albedo), wi, wo)), theirs, rtol=1e-5)


def test_principled_agrees_within_its_known_differences(directions):
    # Mitsuba's has exact dielectric Fresnel, no remap, other luminance weights and a clearcoat of its own: a metal
    # without clearcoat is the part that both share.
    wi, wo = directions
    base = np.array([0.9, 0.6, 0.3])
    description = {
        "type": "principled",
        "base_color": {"type": "rgb", "value": base.tolist()},
        "metallic": 1.0,
        "roughness": 0.5,
        "specular": 0.5,
    }
    model = MODELS["disney"](base_color=base, metallic=1.0, roughness=0.5)
    ours, theirs = np.asarray(evaluate(model, wi, wo)), reflected(description, wi, wo)
    np.testing.assert_allclose(ours, theirs, rtol=1e-3, atol=1e-4)
