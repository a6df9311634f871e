"""A measured complex index of refraction, n(wavelength) + i k(wavelength), to one index per colour channel.

The spectral reflectance of a smooth conductor in unpolarised light, F(wavelength, theta), has a colour at every angle:
light of an illuminant (D65) after it, CIE 1931 2 degree observer, linear Rec. 709, adapted (Bradford) so that a
perfect mirror is white. A renderer with three channels wants one (eta, k) per channel whose own Fresnel reflectance
follows that colour. Averages of n and of k do not: reflectance is not linear in them.

At normal incidence the pair reproduces the colour exactly, as if that angle had infinite weight: all pairs of a
reflectance F0 lie on the circle eta^2 - 2 s eta + 1 + k^2 = 0, s = (1 + F0) / (1 - F0). Along it one minimum, found
by search, of the squared difference over 0 to 85 degrees, weighted with cos(theta), decides.

The colour of a channel may be above 1 or below 0, outside Rec. 709, as gold's red is: it is clipped, and that is told.
"""

from __future__ import annotations

import dataclasses
import os
import pathlib
import re
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from brdf.errors import FileError, UserError, nearest
from brdf.fresnel import f_conductor
from brdf.metals import F0_MAX, F0_MIN
from brdf.parameter import parameters
from brdf.registry import MODELS

# Where the observer's table lies, in steps of 1 nm.
WAVELENGTHS_NM = np.arange(360.0, 831.0)
# What a file has to cover, and the widest gap in it that a straight line may bridge.
NEEDED_NM = (400.0, 700.0)
GAP_MAX_NM = 100.0
# No material has values beyond these; within them the reflectance is finite in float64.
PLAUSIBLE = {"n": (1e-4, 100.0), "k": (1e-6, 100.0)}
# Room for some 30,000 rows.
SIZE_MAX = 2**20
# Bounds of the parameters `eta` and `k` of the models.
ETA_BOUNDS, K_BOUNDS = ((p.lower, p.upper) for p in parameters(MODELS["ggx"]) if p.name in ("eta", "k"))
ANGLES_DEG = np.arange(86.0)
# Each round of the search narrows the bracket 32 times: 7 rounds take it from a factor 1e4 to 1e-9.
_CANDIDATES, _ROUNDS = 65, 7


@dataclasses.dataclass(frozen=True)
class Spectrum:
    """A complex index of refraction n + i k at every `WAVELENGTHS_NM`, and who measured it."""

    n: np.ndarray
    k: np.ndarray
    source: str


@dataclasses.dataclass(frozen=True)
class Conductor:
    """One complex index per channel, linear Rec. 709, that stands for a spectrum.

    **Arguments:**

    - `eta`, `k`: shape (3,), inside `ETA_BOUNDS` and `K_BOUNDS`.
    - `color`: shape (3,), the colour at normal incidence before channels outside [0, 0.9999] were clipped.
    - `rms`, `worst`: shape (3,), the difference between the Fresnel reflectance of (eta, k) and the (clipped) colour
      of the spectrum over 0 to 85 degrees: root mean square, weighted with the cosine, and largest.
    - `source`: who measured the spectrum.
    """

    eta: np.ndarray
    k: np.ndarray
    color: np.ndarray
    rms: np.ndarray
    worst: np.ndarray
    source: str


def read_spectrum(path: str | os.PathLike[str]) -> Spectrum:
    """Reads n and k: a refractiveindex.info file (.yml, tabulated) or a table (.csv: `wavelength_um`, `n`, `k`).

    Between the rows n and k are straight lines, beyond them constant.

    **Raises:** `FileError` that names the place, on a file that is empty, too large or no text, rows that are no
    numbers, not finite or negative, n or k that is missing, and wavelengths that do not cover 400-700 nm.
    """
    suffix = pathlib.Path(path).suffix.lower()
    if suffix not in (".yml", ".yaml", ".csv"):
        raise FileError(path, "is neither .yml nor .csv.", "Give a file of refractiveindex.info or a table of n and k.")
    with open(path, "rb") as file:
        data = file.read(SIZE_MAX + 1)
    if len(data) > SIZE_MAX:
        raise FileError(path, f"has more than {SIZE_MAX // 2**20} MiB.", "A table of n and k has a few hundred rows.")
    if not data.strip():
        raise FileError(path, "is empty.", "Download it again.")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(path, f"byte {error.start} is not UTF-8 text.", "Save it as text in UTF-8.") from error
    tables, source = _parse_csv(path, text) if suffix == ".csv" else _parse_yaml(path, text)
    return Spectrum(_resample(path, "n", tables["n"]), _resample(path, "k", tables["k"]), source)


def effective_index(spectrum: Spectrum, illuminant: str = "D65") -> Conductor:
    """The complex index per channel whose Fresnel reflectance follows the colour of a metal; see the module.

    **Arguments:**

    - `spectrum`: the metal.
    - `illuminant`: a name of CIE, `D65`, `D50`, `A`, `E`, `FL2`, as `colour-science` has it.

    **Raises:** `UserError` for an unknown illuminant.
    """
    cos = np.cos(np.radians(ANGLES_DEG))
    color = reflectance(spectrum.n, spectrum.k, cos) @ _channel_weights(illuminant)
    target = np.clip(color, F0_MIN, F0_MAX)
    weight = (cos / cos.sum())[:, None]
    # The circle's centre; and where along it, between the two ends with the smallest k, k is inside its bounds.
    centre = (1 + target[0]) / (1 - target[0])
    radius = np.sqrt(np.maximum(centre**2 - 1 - K_BOUNDS[0] ** 2, 0))
    below_k_max = np.sqrt(np.maximum(centre**2 - 1 - K_BOUNDS[1] ** 2, 0))
    highest = np.where(below_k_max > 0, (1 + K_BOUNDS[1] ** 2) / (centre + below_k_max), centre + radius)
    # 1 / (centre + radius) is centre - radius without its cancellation.
    low = np.clip((1 + K_BOUNDS[0] ** 2) / (centre + radius), *ETA_BOUNDS)
    high = np.clip(highest, *ETA_BOUNDS)
    channel = np.arange(3)
    for _ in range(_ROUNDS):
        eta = np.geomspace(low, high, _CANDIDATES)
        difference = reflectance(eta, _on_circle(eta, centre), cos) - target[:, None]
        best = (weight[..., None] * difference**2).sum(0).argmin(0)
        low, high = eta[np.maximum(best - 1, 0), channel], eta[np.minimum(best + 1, _CANDIDATES - 1), channel]
    eta = np.sqrt(low * high)
    k = _on_circle(eta, centre)
    difference = reflectance(eta, k, cos) - target
    return Conductor(
        eta=eta,
        k=k,
        color=color[0],
        rms=np.sqrt((weight * difference**2).sum(0)),
        worst=np.abs(difference).max(0),
        source=spectrum.source,
    )


def _on_circle(eta: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """The k, inside its bounds, that gives `eta` the reflectance of the circle around `centre`."""
    return np.sqrt(np.clip(2 * centre * eta - eta**2 - 1, K_BOUNDS[0] ** 2, K_BOUNDS[1] ** 2))


def reflectance(eta: np.ndarray, k: np.ndarray, cos: np.ndarray) -> np.ndarray:
    """Fresnel reflectance of unpolarised light, shape (angles, *shape of `eta`), whose size is a multiple of 3."""
    with jax.enable_x64(True):
        # `f_conductor` takes three channels at a time; 157 triples make the 471 wavelengths.
        values = _fresnel(jnp.asarray(eta.reshape(-1, 3)), jnp.asarray(k.reshape(-1, 3)), jnp.asarray(cos))
        return np.asarray(values).reshape(len(cos), *eta.shape)


@jax.jit
def _fresnel(eta: jax.Array, k: jax.Array, cos: jax.Array) -> jax.Array | np.ndarray:
    at_one_angle = jax.vmap(f_conductor, (0, 0, None, None))
    return jax.vmap(at_one_angle, (None, None, 0, 0))(eta, k, cos, 1 - cos)


def _channel_weights(illuminant: str) -> np.ndarray:
    """What each of `WAVELENGTHS_NM` contributes to red, green and blue: (n, 3), every column sums to 1."""
    import colour  # slow to import, and only this needs it

    known = {name.lower(): name for name in colour.SDS_ILLUMINANTS}
    if illuminant.lower() not in known:
        raise UserError(f"`{illuminant}` is not an illuminant. {nearest(illuminant, known.values())}")
    shape = colour.SpectralShape(WAVELENGTHS_NM[0], WAVELENGTHS_NM[-1], 1)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape).values
    light = colour.SDS_ILLUMINANTS[known[illuminant.lower()]].copy().align(shape).values
    xyz = observer * light[:, None]
    xyz /= xyz[:, 1].sum()
    space = colour.RGB_COLOURSPACES["ITU-R BT.709"]
    white = space.matrix_RGB_to_XYZ.sum(1)
    adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(xyz.sum(0), white, transform="Bradford")
    return xyz @ (space.matrix_XYZ_to_RGB @ adapt).T


def _resample(path: str | os.PathLike[str], name: str, rows: list[tuple[float, float]]) -> np.ndarray:
    """One column, (wavelength in um, value) in any order, at `WAVELENGTHS_NM`."""
    if not rows:
        raise FileError(path, f"has no `{name}`.", "A metal needs n and k, tabulated over 0.4-0.7 um.")
    # A row that is there twice counts once.
    um, value = np.array(sorted(set(rows))).T
    nm = um * 1e3
    if (same := np.diff(nm) <= 0).any():
        raise FileError(path, f"has two values of `{name}` at {um[same.argmax()]:g} um.", "Remove one.")
    if nm[0] > NEEDED_NM[0] or nm[-1] < NEEDED_NM[1]:
        hint = " These look like nanometres: divide by 1000." if nm[0] > 1e5 else ""
        raise FileError(
            path,
            f"`{name}` is given for {um[0]:g}-{um[-1]:g} um, which does not cover 0.4-0.7 um.{hint}",
            "Choose a measurement that covers the visible range.",
        )
    seen = (nm[1:] > NEEDED_NM[0]) & (nm[:-1] < NEEDED_NM[1])
    if (gap := np.diff(nm) * seen).max() > GAP_MAX_NM:
        place = gap.argmax()
        raise FileError(
            path,
            f"`{name}` has no row between {um[place]:g} and {um[place + 1]:g} um.",
            f"Rows of the visible range may be {GAP_MAX_NM:g} nm apart.",
        )
    values = np.interp(WAVELENGTHS_NM, nm, value)
    low, high = PLAUSIBLE[name]
    if not (low <= values.min() and values.max() <= high):
        raise FileError(
            path,
            f"`{name}` runs from {values.min():g} to {values.max():g} in the visible range.",
            f"It is {low:g}-{high:g} for any metal. Check the columns: wavelength, n, k.",
        )
    return values


def _numbers(path: str | os.PathLike[str], place: str, fields: list[str], count: int) -> list[float]:
    """One row: a wavelength above 0, then values of at least 0."""
    if len(fields) != count:
        raise FileError(path, f"{place} has {len(fields)} numbers instead of {count}.", "Mend that row.")
    try:
        values = [float(field) for field in fields]
    except ValueError as error:
        raise FileError(
            path, f"{place} holds {str(error).rpartition(': ')[2]}, no number.", "Mend that row."
        ) from error
    if not (np.isfinite(values).all() and values[0] > 0 and min(values) >= 0):
        problem = f"{place}, `{' '.join(fields)}`, holds a value that is not finite or is negative."
        raise FileError(path, problem, "Mend or remove that row.")
    return values


Tables = dict[str, list[tuple[float, float]]]


def _parse_csv(path: str | os.PathLike[str], text: str) -> tuple[Tables, str]:
    """Rows of `n` and of `k`, and the file's name."""
    order: list[int] = []
    tables: Tables = {"n": [], "k": []}
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        fields = [field.strip() for field in re.split(r"[,;\t]", line)]
        if not order:
            if sorted(fields) != ["k", "n", "wavelength_um"]:
                problem = f"line {number} names the columns {', '.join(f'`{field}`' for field in fields[:9])}."
                raise FileError(path, problem, "They have to be wavelength_um, n and k.")
            order = [fields.index(name) for name in ("wavelength_um", "n", "k")]
            continue
        um, n, k = _numbers(path, f"line {number}", [fields[i] for i in order] if len(fields) == 3 else fields, 3)
        tables["n"].append((um, n))
        tables["k"].append((um, k))
    return tables, os.path.basename(path)


def _parse_yaml(path: str | os.PathLike[str], text: str) -> tuple[Tables, str]:
    """Rows of `n` and of `k` of all DATA blocks, and the first reference as authors and year."""
    try:
        import yaml
    except ImportError as error:
        raise FileError(path, "needs the package PyYAML to be read.", "pip install pyyaml") from error

    try:
        # The base loader leaves every scalar a string: no dates or numbers are guessed at.
        content: Any = yaml.load(text, Loader=yaml.BaseLoader)
    except (yaml.YAMLError, RecursionError) as error:
        line = getattr(getattr(error, "problem_mark", None), "line", None)
        place = "" if line is None else f" (line {line + 1})"
        raise FileError(path, f"is not YAML{place}.", "Download it again from refractiveindex.info.") from error
    blocks = content.get("DATA") if isinstance(content, dict) else None
    if not (isinstance(blocks, list) and blocks and all(isinstance(block, dict) for block in blocks)):
        raise FileError(path, "has no list `DATA`.", "Give a file of refractiveindex.info.")
    tables: Tables = {"n": [], "k": []}
    for number, block in enumerate(blocks, 1):
        kind, rows = block.get("type"), block.get("data")
        names = {"tabulated nk": "nk", "tabulated n": "n", "tabulated k": "k"}.get(str(kind))
        if names is None or not isinstance(rows, str):
            what = f"is of type `{kind}`" if names is None else "has no `data`"
            raise FileError(path, f"DATA block {number} {what}.", "Metals are read from tabulated nk, n or k.")
        for place, line in enumerate(filter(str.strip, rows.splitlines()), 1):
            um, *values = _numbers(path, f"row {place} of DATA block {number}", line.split(), 1 + len(names))
            for name, value in zip(names, values, strict=True):
                tables[name].append((um, value))
    return tables, _citation(str(content.get("REFERENCES", ""))) or os.path.basename(path)


def _citation(reference: str) -> str:
    """Authors, year and DOI of the first reference: `Johnson and Christy 1972, doi:10.1103/PhysRevB.6.4370`."""
    # Authors end with the first full stop after a word: the ones before stand after initials.
    plain = re.sub(r"<[^>]*>", "", reference)
    authors = re.match(r"\s*(?:\d+\)\s*)?(.+?\w{3,})\.(?:\s|$)", plain)
    year = re.search(r"\((\d{4})\)", plain)
    if not (authors and year):
        return ""
    names = [part for part in re.split(r",\s*(?:and\s+)?|\s+and\s+", authors[1]) if part]
    surnames = [
        " ".join(word for word in name.split() if not re.fullmatch(r"(?:\w{1,2}\.-?)+", word)) for name in names
    ]
    # A DOI may hold pairs of brackets; a lone closing one ends the link.
    doi = re.search(r"doi\.org/((?:\([^\s()]*\)|[^\s\"'<>()\]])+)", reference)
    who = f"{surnames[0]} et al." if len(surnames) > 2 else " and ".join(surnames)
    return f"{who} {year[1]}" + (f", doi:{doi[1]}" if doi else "")
