"""The diffuse models against independent values: plain numpy from the papers, 50 digits, quadrature, closed forms."""

import cases
import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from brdf import MODELS, evaluate

ROUGHNESSES = [0.0, 1e-3, 0.1, 0.35, 0.7, 1.0]
SIGMAS = [0.0, 0.02, 0.1986, 0.3, 0.8, np.pi / 2]
WHITE = [0.2, 0.7, 1.0]


def angles(wi, wo):
    """Cosines, `cos(dphi)` and `cos_d^2` from normalised vectors, as the papers write them."""
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    cos_d = np.sum(wi * h, axis=1)
    phi_i, phi_o = np.arctan2(wi[:, 1], wi[:, 0]), np.arctan2(wo[:, 1], wo[:, 0])
    return wi[:, 2], wo[:, 2], np.cos(phi_i - phi_o), cos_d**2


def steep_pairs(seed, count):
    """Pairs at least 1e-3 above the horizon, where the published formulas in float64 keep enough digits."""
    wi, wo = cases.pairs(seed, count)
    keep = (wi[:, 2] > 1e-3) & (wo[:, 2] > 1e-3)
    return wi[keep], wo[keep]


def burley(cos_i, cos_o, cos2_d, roughness):
    f_d90 = 0.5 + 2 * cos2_d * roughness
    return (1 + (f_d90 - 1) * (1 - cos_i) ** 5) * (1 + (f_d90 - 1) * (1 - cos_o) ** 5) / np.pi


def subsurface(cos_i, cos_o, cos2_d, roughness):
    f_ss90 = cos2_d * roughness
    f_ss = (1 + (f_ss90 - 1) * (1 - cos_i) ** 5) * (1 + (f_ss90 - 1) * (1 - cos_o) ** 5)
    return 1.25 * (f_ss * (1 / (cos_i + cos_o) - 0.5) + 0.5) / np.pi


@pytest.mark.parametrize("roughness", ROUGHNESSES)
@pytest.mark.parametrize(("name", "paper"), [("burley", burley), ("hanrahan_krueger", subsurface)])
def test_disney_terms_equal_the_course_notes(name, paper, roughness):
    wi, wo = steep_pairs(21, 4000)
    cos_i, cos_o, _, cos2_d = angles(wi, wo)
    value = evaluate(MODELS[name](albedo=WHITE, roughness=roughness), wi, wo)
    expected = paper(cos_i, cos_o, cos2_d, roughness)[:, None] * WHITE
    # The half vector of opposite directions loses digits in the normalised form, not here.
    np.testing.assert_allclose(value, expected, rtol=1e-10)


def test_disney_terms_equal_brdf_explorer(shared):
    # Oracle: Disney's own shader. What is not diffuse is taken off by a numpy transcription of the other terms.
    file = np.load(shared / "oracle" / "disney.npz")
    p = {str(name): file["params"][:, [column]] for column, name in enumerate(file["names"])}
    wi, wo = file["wi"], file["wo"]
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    cos_i, cos_o, cos_h, cos_d = wi[:, [2]], wo[:, [2]], h[:, [2]], np.sum(wi * h, axis=1, keepdims=True)
    base = np.concatenate([p[f"baseColor_{channel}"] for channel in "rgb"], axis=1) ** 2.2
    luminance = base @ np.array([[0.3], [0.6], [0.1]])
    tint = base / np.where(luminance > 0, luminance, 1)

    def mix(a, b, t):
        return a * (1 - t) + b * t

    aspect = np.sqrt(1 - 0.9 * p["anisotropic"])
    alpha_x = np.maximum(1e-3, p["roughness"] ** 2 / aspect)
    alpha_y = np.maximum(1e-3, p["roughness"] ** 2 * aspect)
    slope2 = (h[:, [0]] / alpha_x) ** 2 + (h[:, [1]] / alpha_y) ** 2
    schlick = (1 - cos_d) ** 5
    specular = mix(mix(0.08 * p["specular"] * mix(1, tint, p["specularTint"]), base, p["metallic"]), 1, schlick)
    specular = specular / (np.pi * alpha_x * alpha_y * (slope2 + cos_h**2) ** 2)
    for w in (wi, wo):
        stretched = (w[:, [0]] * alpha_x) ** 2 + (w[:, [1]] * alpha_y) ** 2 + w[:, [2]] ** 2
        specular = specular / (w[:, [2]] + np.sqrt(stretched))
    a2 = mix(0.1, 0.001, p["clearcoatGloss"]) ** 2
    clearcoat = 0.25 * p["clearcoat"] * mix(0.04, 1, schlick)
    clearcoat = clearcoat * (a2 - 1) / (np.pi * np.log(a2) * (1 + (a2 - 1) * cos_h**2))
    for cosine in (cos_i, cos_o):
        clearcoat = clearcoat / (cosine + np.sqrt(0.0625 + 0.9375 * cosine**2))
    sheen = schlick * p["sheen"] * mix(1, tint, p["sheenTint"])
    rest = specular + clearcoat + sheen * (1 - p["metallic"])

    def lobe(name):
        by = jax.vmap(lambda c, r, i, o: MODELS[name](albedo=c, roughness=r)(i, o))
        return np.asarray(jax.jit(by)(base, p["roughness"][:, 0], wi, wo))

    diffuse = mix(lobe("burley"), lobe("hanrahan_krueger"), p["subsurface"]) * (1 - p["metallic"])
    # Under a highlight the difference has no digits left; a metal and a black base have no diffuse part.
    counted = (diffuse > 0) & (rest < 100 * diffuse)
    assert counted.sum() > 2000
    np.testing.assert_allclose((file["value"] - rest)[counted], diffuse[counted], rtol=1e-10)


@pytest.mark.parametrize("sigma", SIGMAS)
def test_qualitative_oren_nayar_equals_its_published_form(sigma):
    wi, wo = steep_pairs(22, 4000)
    cos_i, cos_o, cos_dphi, _ = angles(wi, wo)
    theta_i, theta_o = np.arccos(np.minimum(cos_i, 1)), np.arccos(np.minimum(cos_o, 1))
    alpha, beta = np.maximum(theta_i, theta_o), np.minimum(theta_i, theta_o)
    a = 1 - 0.5 * sigma**2 / (sigma**2 + 0.33)
    b = 0.45 * sigma**2 / (sigma**2 + 0.09)
    expected = (a + b * np.maximum(0, cos_dphi) * np.sin(alpha) * np.tan(beta)) / np.pi
    value = evaluate(MODELS["oren_nayar"](albedo=WHITE, sigma=sigma, form="qualitative"), wi, wo)
    # The tangent of an arc cosine 1e-3 from the horizon.
    np.testing.assert_allclose(value, expected[:, None] * WHITE, rtol=1e-10)


def eon(rho, r, wi, wo, form):
    """Listing 1 of Portsmouth, Kutz and Hill 2025 on numbers of mpmath."""
    pi = mpmath.pi
    wi, wo = ([mpmath.mpf(x) for x in w] for w in (wi, wo))
    wi, wo = ([x / mpmath.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2) for x in w] for w in (wi, wo))
    rho, r = mpmath.mpf(float(rho)), mpmath.mpf(float(r))
    c1, c2 = mpmath.mpf(1) / 2 - 2 / (3 * pi), mpmath.mpf(2) / 3 - 28 / (15 * pi)
    a = 1 / (1 + c1 * r)

    def directional(mu):
        if form == "polynomial":
            x = 1 - mu
            g = sum(c * x**n for n, c in enumerate((0.0571085289, 0.491881867, -0.332181442, 0.0714429953), 1))
            return min(a * (1 + r * g), 1)
        sine = mpmath.sqrt(1 - mu**2)
        g = sine * (mpmath.acos(mu) - sine * mu) + (sine / mu * (1 - sine**3) - sine) * 2 / 3
        return a * (1 + r * g / pi)

    s = wi[0] * wo[0] + wi[1] * wo[1]
    s_over_t = s / max(wi[2], wo[2]) if s > 0 else s
    mean = a * (1 + c2 * r)
    rho_ms = rho**2 * mean / (1 - rho * (1 - mean))
    value = rho / pi * a * (1 + r * s_over_t)
    if r > 0:
        value += rho_ms / pi * (1 - directional(wi[2])) * (1 - directional(wo[2])) / (1 - mean)
    return float(value)


@pytest.mark.parametrize("form", ["exact", "polynomial"])
@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_eon_equals_its_paper_in_50_digits_down_to_grazing(roughness, form):
    wi, wo = cases.pairs(23, 160)
    # A dot product of directions that graze the surface at right angles loses digits: mathematics, not the model.
    sines = np.hypot(wi[:, 0], wi[:, 1]) * np.hypot(wo[:, 0], wo[:, 1])
    aligned = np.abs(wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1]) >= 0.1 * sines
    wi, wo = wi[aligned], wo[aligned]
    for dtype, rtol, atol in ((np.float64, 1e-13, 1e-15), (np.float32, 2e-6, 1e-7)):
        pair = wi.astype(dtype), wo.astype(dtype)
        model = MODELS["eon"](albedo=WHITE, roughness=roughness, albedo_form=form)
        model = jax.tree.map(lambda leaf, dtype=dtype: jnp.asarray(leaf, dtype), model)
        value = np.asarray(evaluate(model, *pair))
        assert value.dtype == dtype
        exact = (w.astype(np.float64).tolist() for w in pair)
        with mpmath.workdps(50):
            expected = [[eon(rho, model.roughness, *w, form) for rho in model.albedo] for w in zip(*exact, strict=True)]
        # Rounding to a unit vector moves 1 + s by one unit: that alone is the absolute tolerance.
        np.testing.assert_allclose(value, expected, rtol=rtol, atol=atol)


@pytest.mark.parametrize("cosine", [1e-4, 1e-2])
def test_eon_keeps_its_digits_between_opposite_grazing_directions(cosine):
    # 1 + s is about cos^2 there, and 1 - E about cos: both far below one unit of the numbers they are differences of.
    pair = [np.array([[sign, 0.0, cosine]]) / np.hypot(1, cosine) for sign in (1, -1)]
    for dtype, rtol in ((np.float64, 1e-14), (np.float32, 1e-6)):
        model = jax.tree.map(lambda leaf, dtype=dtype: jnp.asarray(leaf, dtype), MODELS["eon"](albedo=1, roughness=1.0))
        wi, wo = (w.astype(dtype) for w in pair)
        with mpmath.workdps(50):
            # The horizontal parts follow from the rounded cosine: rounding them is what float32 cannot hold.
            c = float(wi[0, 2])
            expected = eon(1, 1, *([sign * mpmath.sqrt(1 - mpmath.mpf(c) ** 2), 0, c] for sign in (1, -1)), "exact")
        np.testing.assert_allclose(np.asarray(evaluate(model, wi, wo))[0], expected, rtol=rtol)


def albedo(model, theta):
    """The reflected share of light from one direction, by Gauss-Legendre in the polar angle and a half turn.

    Between the kinks of these models, which lie at equal polar angles and at right angles of azimuth, it is exact to
    about 1e-9; `brdf.integrate.albedo`, which knows of no kink, is to 3e-5.
    """
    point, weight = np.polynomial.legendre.leggauss(40)
    point, weight = 0.5 * (1 + point), 0.5 * weight
    theta_i = np.concatenate([theta * point, theta + (np.pi / 2 - theta) * point])
    theta_weight = np.concatenate([theta * weight, (np.pi / 2 - theta) * weight])
    phi = np.concatenate([0.5 * np.pi * point, 0.5 * np.pi * (1 + point)])
    phi_weight = np.tile(np.pi * weight, 2)
    sine, cosine = np.sin(theta_i), np.cos(theta_i)
    wi = np.stack([np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(cosine, np.ones(80))], axis=-1)
    wo = np.broadcast_to([np.sin(theta), 0.0, np.cos(theta)], (6400, 3))
    value = np.asarray(evaluate(model, wi.reshape(-1, 3), wo))[:, 1].reshape(80, 80)
    return float((theta_weight * sine * cosine) @ value @ phi_weight)


@pytest.mark.parametrize("roughness", ROUGHNESSES)
@pytest.mark.parametrize("theta", [0.0, 0.4, 1.0, 1.4, 1.55, 1.5707])
def test_white_eon_reflects_everything(roughness, theta):
    assert albedo(MODELS["eon"](albedo=1.0, roughness=roughness), theta) == pytest.approx(1, abs=1e-8)
    # The published polynomial is off by 6.1e-4 of the rough part.
    model = MODELS["eon"](albedo=1.0, roughness=roughness, albedo_form="polynomial")
    assert albedo(model, theta) == pytest.approx(1, abs=6.1e-4 * roughness + 1e-8)


@pytest.mark.parametrize(
    "smooth",
    [
        MODELS["eon"](albedo=WHITE, roughness=0.0),
        MODELS["eon"](albedo=WHITE, roughness=0.0, albedo_form="polynomial"),
        MODELS["oren_nayar"](albedo=WHITE, sigma=0.0),
        MODELS["oren_nayar"](albedo=WHITE, sigma=0.0, form="qualitative"),
    ],
)
def test_without_roughness_every_facet_model_is_lambert(smooth):
    wi, wo = cases.pairs(24, 2000)
    np.testing.assert_array_equal(evaluate(smooth, wi, wo), evaluate(MODELS["lambert"](albedo=WHITE), wi, wo))


def test_disney_terms_are_what_they_are_at_normal_incidence():
    # Closed forms: no Schlick weight is left, and 1 / (1 + 1) - 1/2 = 0.
    up = np.array([[0.0, 0.0, 1.0]])
    for roughness in (0.0, 0.3, 1.0):
        value = evaluate(MODELS["burley"](albedo=WHITE, roughness=roughness), up, up)
        np.testing.assert_allclose(value, np.array([WHITE]) / np.pi, rtol=1e-15)
        value = evaluate(MODELS["hanrahan_krueger"](albedo=WHITE, roughness=roughness), up, up)
        np.testing.assert_allclose(value, 0.625 * np.array([WHITE]) / np.pi, rtol=1e-15)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("cosine", [1.1e-9, 3.3e-8])
def test_subsurface_term_is_right_where_both_directions_touch_the_horizon(cosine, dtype):
    # Oracle: the formula in float64, with expm1 and log1p for 1 - (1 - c)^5; the second cosine is half a unit below 1.
    c = float(dtype(cosine))
    wi = np.array([[1, 0, c], [1, 0, c]], dtype)
    wo = np.array([[1, 0, c], [-1, 0, c]], dtype)
    lost = -np.expm1(5 * np.log1p(-c))
    for roughness in (0.0, 1.0):
        model = MODELS["hanrahan_krueger"](albedo=1.0, roughness=roughness)
        model = jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype), model)
        f_ss = np.array([lost + roughness * (1 - lost), lost]) ** 2
        expected = 1.25 * (f_ss * (1 / (2 * c) - 0.5) + 0.5) / np.pi
        np.testing.assert_allclose(np.asarray(evaluate(model, wi, wo))[:, 0], expected, rtol=4e-7)
        gradient = jax.grad(lambda wi, model=model, wo=wo[0]: model(wi, wo).sum())(jnp.asarray(wi[0]))
        assert np.isfinite(np.asarray(gradient)).all()


# The largest albedo over all parameters and angles, found at a grazing angle: closed forms of the integral there, but
# for the subsurface term, whose number is Gauss-Legendre quadrature outside of this package, and for the full form.
@pytest.mark.parametrize(
    ("model", "largest", "claimed"),
    [
        (MODELS["burley"](albedo=1.0, roughness=1.0), 1.5 + 29 / 504, 1.5576),
        (MODELS["hanrahan_krueger"](albedo=1.0, roughness=1.0), 1.5125868, 1.513),
        (MODELS["oren_nayar"](albedo=1.0, sigma=0.305), 1.05102, 1.052),
        (
            MODELS["oren_nayar"](albedo=1.0, sigma=0.1986, form="qualitative"),
            1 - 0.5 * 0.1986**2 / (0.1986**2 + 0.33) + 0.225 * 0.1986**2 / (0.1986**2 + 0.09),
            1.0152,
        ),
    ],
)
def test_the_claimed_albedo_is_reached_and_not_exceeded(model, largest, claimed):
    assert model.claims().albedo_max == claimed
    assert largest <= claimed <= largest * (1 + 1e-3)
    # 1e-6 above the horizon the albedo is the limit's to a few of these.
    assert albedo(model, np.pi / 2 - 1e-6) == pytest.approx(largest, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "choices"),
    [
        ("burley", {}),
        ("hanrahan_krueger", {}),
        ("oren_nayar", {"form": "full"}),
        ("oren_nayar", {"form": "qualitative"}),
        ("eon", {"albedo_form": "polynomial"}),
    ],
)
def test_no_roughness_exceeds_the_claimed_albedo(name, choices):
    name_of_rough, values = ("sigma", SIGMAS) if name == "oren_nayar" else ("roughness", ROUGHNESSES)
    for value in values:
        model = MODELS[name](albedo=1.0, **{name_of_rough: value}, **choices)
        for theta in (0.0, 0.6, 1.1, 1.3, 1.4, 1.45, 1.5, 1.55, 1.57, 1.5707):
            # The cut at zero of the full Oren-Nayar form is a kink that the rule does not know.
            assert albedo(model, theta) <= model.claims().albedo_max * (1 + 1e-5)
