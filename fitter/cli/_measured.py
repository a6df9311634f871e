"""What the preview can show: a material, or a measurement as a table over half and difference angles."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

from brdf.errors import UserError

if TYPE_CHECKING:
    import numpy as np

    from shaders.tabulated import Tabulated
    from shaders.twin import Twin

    from ..reflectance import Reflectance

# Nodes along theta_h, theta_d and phi_d, within the 16 MB that OpenGL 4.3 promises of a buffer. theta_h has two nodes
# per cell of an RGL file. Twelve of them against an independent evaluation, where both cosines are above 0.05, a third
# of the pairs near the mirror direction: the mean error of log(1 + f cos_i) is 0.0003 to 0.0066, the median error of f
# at most 0.6 %.
_NODES = (255, 76, 72)
# Closer to the horizon than this cosine nothing is asked of a measurement: RGL's values grow with 1 / cos_o.
_COSINE_MIN = 1e-3
# An isotropic interpolation changes by rounding alone when both directions are turned about the normal.
_TURN_ERROR = 1e-4
# Nodes of phi_d up to which a hole looks for neighbours around the end of the axis.
_HOLE_MAX = 8


def material_of(path: str, read_options: Mapping[str, str] | None = None) -> Twin:
    """What a `Part` is made of, from a material (.json) or from a measurement of any format that defines its values.

    A material whose kind was seen before needs no JAX, see `shaders.kept_models`.

    **Arguments:**

    - `path`: the file.
    - `read_options`: of the measurement's reader, as in `fitter.formats.read`.

    Raises `FileError` as the readers do; `UserError` for options of a reader with a material, or as `tabulated` does.
    """
    if pathlib.Path(path).suffix.lower() == ".json":
        if read_options:
            raise UserError(f"`--read` is for measurements, and `{path}` is a material. Leave `--read` out.")
        from shaders.kept_models import twin_of_file

        return twin_of_file(path)
    from ..formats import read

    return tabulated(read(path, read_options)).twin


def tabulated(measured: Reflectance) -> Tabulated:
    """A measurement as the preview's table: a MERL table as it is, anything else resampled by its own interpolation.

    Holes and what lies below the horizon get the values of their nearest neighbours; negative values become 0.

    Raises `UserError` if the format has no interpolation, if the measurement is anisotropic, or without a valid value.
    """
    import numpy as np

    from shaders.tabulated import Tabulated, axes

    from ..formats import merl

    if measured.interpolant is None:
        raise UserError(
            f"`{measured.source}` holds scattered samples, between which its format defines no value. Fit a model and "
            "preview that: `brdf fit ... -o material.json`, then `brdf preview material.json`."
        )
    cells = merl.cells_of(measured.grid)
    if measured.grid is not None and cells is not None:
        table = _filled(measured.grid.scatter(measured.value), measured.source)
        return Tabulated(table, cells, is_reciprocal=True)
    _refuse_anisotropic(measured)
    from ..rusinkiewicz import directions

    theta_h, theta_d, phi_d = axes(_NODES)
    table = np.full((*_NODES, 3), np.nan)
    for row, angle in enumerate(theta_h):
        wi, wo = directions(angle, theta_d[:, None], phi_d)
        above = (wi[..., 2] > _COSINE_MIN) & (wo[..., 2] > _COSINE_MIN)
        if above.any():
            table[row][above] = np.maximum(measured.evaluate(wi[above], wo[above]), 0) * wo[above][:, 2:]
    return Tabulated(_filled(table, measured.source), holds="f cos_o")


def _refuse_anisotropic(measured: Reflectance) -> None:
    import numpy as np

    rng = np.random.default_rng(0)
    w = rng.normal(size=(2, 512, 3))
    wi, wo = w * np.sign(w[..., 2:]) / np.linalg.norm(w, axis=-1, keepdims=True)
    # A turn that maps no symmetry of a measurement onto itself.
    c, s = np.cos(1.0), np.sin(1.0)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    before, after = measured.evaluate(wi, wo), measured.evaluate(wi @ turn.T, wo @ turn.T)
    change = np.nansum(np.abs(after - before)) / np.nansum(np.abs(before))
    if change > _TURN_ERROR:
        raise UserError(
            f"`{measured.source}` is anisotropic: turned about its normal, its values change by {change:.2g} of their "
            "mean. Measurements are rendered as isotropic tables only. Fit a model to it and preview that: "
            "`brdf fit ... -o material.json`, then `brdf preview material.json`."
        )


def _filled(table: np.ndarray, source: str) -> np.ndarray:
    """The table in float32, NaN replaced by the nearest node that is none; phi_d goes round."""
    import numpy as np
    from scipy import ndimage

    layers = table.shape[2]
    holes = np.isnan(table[..., 0])
    if holes.all():
        raise UserError(f"`{source}` has no value above the horizon. Read another file.")
    around = min(_HOLE_MAX, layers)
    padded = np.pad(holes, ((0, 0), (0, 0), (around, around)), mode="wrap")
    nearest = np.asarray(ndimage.distance_transform_edt(padded, return_distances=False, return_indices=True))
    row, column, layer = nearest[..., around : around + layers]
    return table[row, column, (layer - around) % layers].astype(np.float32)
