"""A tabulated BRDF in GLSL against float64: the same table in Python, the model that it was made from, and laws."""

from __future__ import annotations

import numpy as np
import pytest
from directions import adversarial_pairs
from numpy.typing import NDArray

import brdf
from brdf.errors import UserError
from brdf.model import AbstractBRDF
from brdf.registry import combine
from fitter.formats._angular_table import AngularTable
from fitter.rusinkiewicz import directions, half_difference
from shaders import Part, Scene, Tabulated, evaluate, load_environment, pdf, render, sample
from shaders.tabulated import Cells, Holds, axes

LAYOUTS: list[tuple[Cells, bool, Holds]] = [
    ("edge", True, "f"),
    ("centre", True, "f"),
    ("nodes", False, "f"),
    ("nodes", False, "f cos_o"),
]


def _of(model: AbstractBRDF, nodes: tuple[int, int, int]) -> Tabulated:
    """A model on the nodes of a table; below the horizon the value of the node before."""
    theta_h, theta_d, phi_d = axes(nodes)
    wi, wo = directions(theta_h[:, None, None], theta_d[:, None], phi_d)
    above = (wi[..., 2] > 1e-3) & (wo[..., 2] > 1e-3)
    values = np.zeros((*nodes, 3), np.float32)
    values[above] = np.asarray(brdf.evaluate(model, wi[above], wo[above]))
    for column in range(1, nodes[1]):
        values[:, column] = np.where(above[:, column, :, None], values[:, column], values[:, column - 1])
    return Tabulated(values)


def _lambert() -> Tabulated:
    return Tabulated(np.full((2, 2, 1, 3), 1 / np.pi, np.float32))


def _pairs(seed: int = 3, alpha: float = 0.05) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    wi, wo = adversarial_pairs(seed, alpha, 500)
    above = (wi[:, 2] > 1e-6) & (wo[:, 2] > 1e-6)
    return wi[above], wo[above]


@pytest.mark.gpu
@pytest.mark.parametrize(("cells", "is_reciprocal", "holds"), LAYOUTS)
def test_values_between_the_nodes_are_those_of_python(cells: Cells, is_reciprocal: bool, holds: Holds):
    # Oracle: float64 angles and `AngularTable`, which reads MERL files. Smooth but different along every axis.
    nodes = (40, 30, 24)
    h, d, p = np.meshgrid(*axes(nodes, cells, is_reciprocal), indexing="ij")
    wave = 2 + np.cos(2 * p + 0.4) * np.sin(d + h)
    values = np.stack([wave, 1 + h * wave, 3 - d + 0.2 * wave], axis=-1).astype(np.float32)
    wi, wo = _pairs()
    angles = half_difference(wi.astype(np.float64), wo.astype(np.float64))
    offset, ends = (0.5 if cells == "centre" else 0.0), (1 if cells == "nodes" else 0)
    places = (
        np.sqrt(angles.theta_h / (np.pi / 2)) * (nodes[0] - ends) - offset,
        angles.theta_d / (np.pi / 2) * (nodes[1] - ends) - offset,
        angles.phi_d / (np.pi if is_reciprocal else 2 * np.pi) * nodes[2] - offset,
    )
    table = AngularTable(np.moveaxis(values.astype(np.float64), 3, 0), (False, False, True))
    truth = table.interpolate(*places) / (wo[:, 2:] if holds == "f cos_o" else 1)
    found = evaluate(Tabulated(values, cells, is_reciprocal, holds).twin, wi, wo)
    np.testing.assert_allclose(found, truth, rtol=1e-5)


@pytest.mark.gpu
def test_a_tabulated_model_is_the_model_up_to_the_error_of_interpolation():
    # Oracle: the model in float64; the error of a trilinear table falls with the square of the spacing.
    model = combine({"lambert": brdf.build("lambert"), "ggx": brdf.MODELS["ggx"](f0=[0.9, 0.5, 0.3], alpha=0.3)})
    wi, wo = adversarial_pairs(5, 0.3, 2000)
    # At grazing angles a cell may have a corner below the horizon.
    inside = (wi[:, 2] > 0.2) & (wo[:, 2] > 0.2)
    wi, wo = wi[inside], wo[inside]
    truth = np.asarray(brdf.evaluate(model, wi.astype(np.float64), wo.astype(np.float64)))
    errors = []
    for nodes in ((46, 46, 36), (91, 91, 72)):
        found = evaluate(_of(model, nodes).twin, wi, wo)
        errors.append(float(np.quantile(np.abs(found / truth - 1), 0.99)))
    assert errors[0] < 0.02
    assert errors[1] < 0.35 * errors[0]


@pytest.mark.gpu
def test_no_direction_gives_a_value_that_is_not_a_number():
    up, aside = [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]
    grazing = [1.0, 0.0, 2e-9]
    pairs = [(up, up), (aside, aside), (aside, [-0.6, 0, 0.8]), (grazing, [-1.0, 0, 2e-9]), (grazing, grazing)]
    pairs += [(up, grazing), (grazing, up), (grazing, [0.0, 1.0, 2e-9])]
    wi, wo = (np.array(side, np.float32) for side in zip(*pairs, strict=True))
    for cells, is_reciprocal, holds in LAYOUTS:
        table = Tabulated(np.full((5, 4, 3, 3), 0.25, np.float32), cells, is_reciprocal, holds)
        expected = np.broadcast_to(0.25 / (wo[:, 2:] if holds == "f cos_o" else 1), wo.shape)
        np.testing.assert_allclose(evaluate(table.twin, wi, wo), expected, rtol=1e-6)
    assert not evaluate(_lambert().twin, np.array([[0, 0, -1.0]], np.float32), np.array([up], np.float32)).any()


@pytest.mark.gpu
def test_a_white_tabulated_lambert_ball_disappears_in_a_furnace():
    scene = Scene((Part(_lambert().twin),), load_environment("furnace"), width=64, height=64, samples=1600)
    pixels = render(scene).pixels
    assert abs(float(pixels[16:48, 16:48].mean()) - 1) < 1e-3
    np.testing.assert_allclose(pixels, 1, atol=0.02)


@pytest.mark.gpu
@pytest.mark.parametrize("alpha", [0.03, 0.3])
def test_proposals_sample_a_highlight_well(alpha: float):
    # Oracle: the model's own proposals, whose directions estimate the same albedo. A cosine alone would be off by more
    # than its mean for each sample; samples that follow the highlight are off by half of it at most.
    model = brdf.MODELS["ggx"](f0=0.9, alpha=alpha)
    table = _of(model, (128, 46, 36)).twin
    assert table.proposals == 1
    u = np.random.default_rng(2).random((4000, 3), dtype=np.float32)
    wo = np.broadcast_to(np.array([0.5, 0.0, np.sqrt(0.75)], np.float32), u.shape)
    estimates = []
    for material in (model, table):
        wi = sample(material, wo, u)
        ratio = evaluate(material, wi, wo)[:, 0] * wi[:, 2] / np.maximum(pdf(material, wi, wo), 1e-12)
        estimates.append(ratio)
    (exact, found) = (float(one.mean()) for one in estimates)
    assert abs(found / exact - 1) < 0.02
    assert estimates[1].std() < found / 2


def test_tables_that_cannot_be_rendered_are_refused():
    good = np.ones((3, 3, 2, 3), np.float32)
    with pytest.raises(UserError, match="not a table"):
        Tabulated(good[0])
    with pytest.raises(UserError, match="both ends"):
        Tabulated(good[:1])
    with pytest.raises(UserError, match="negative"):
        Tabulated(good - 1.5)
    with pytest.raises(UserError, match="negative"):
        Tabulated(good * np.float32(np.nan))
    with pytest.raises(UserError, match="exchanged"):
        Tabulated(good, is_reciprocal=True, holds="f cos_o")
