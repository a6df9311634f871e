"""RGL `.bsdf`: the adaptive tensors of the EPFL RGL material database.

Fields of the container (see `fitter/tensor_file.py`), angles in radians:

    theta_i, phi_i  incident directions that were measured; one or two phi_i: isotropic
    ndf             distribution of normals D(wm), over (phi, theta)
    sigma           projected area of the facets seen from wi, over (phi, theta)
    vndf            visible normals, per (phi_i, theta_i) over (phi, theta)
    rgb             M, linear Rec. 709, per (phi_i, theta_i), [channel][32][32]
    spectra         M per wavelength instead (field `wavelengths`, nm); the options `illuminant` and `wavelength` say
                    how they become channels
    jacobian        0 if M already holds the factor D / (4 sigma)
    description     text

Angles become coordinates of a unit square by sqrt(2 theta / pi) and (phi + pi) / (2 pi). With
`wm` the half vector and `x` the place that the inverse warp of `vndf` gives it,

    f cos(theta_o) = M(x) D(wm) / (4 sigma(wi))        (Dupuy and Jakob 2018)

so that the BRDF here is the file's number divided by cos_o. Isotropic files use phi_m - phi_i. Some
anisotropic files cover half of phi_i (the other half by turning the sample around) or a quarter
(by mirroring it). `wi` is the direction that was lit, to the light.

The field `valid` holds one bit per node: whether the reflected direction is above the horizon, with
either polarity, depending on the file. That follows from the geometry and is not read.

Dupuy and Jakob 2018: J. Dupuy, W. Jakob, "An Adaptive Parameterization for Efficient Material
Acquisition and Rendering", ACM TOG 37(6), 2018.
"""

from __future__ import annotations

import os

import numpy as np

from brdf.errors import FileError, UserError
from fitter.formats import _spectrum
from fitter.formats._bilinear_warp import BilinearWarp, bilinear, patch, slice_weights
from fitter.formats._scattered import spherical
from fitter.formats._tensor_file import MAGIC, read_tensor_file
from fitter.reflectance import HORIZON_COSINE, Reflectance

NAME = "RGL"
DESCRIPTION = "adaptive tensors of the EPFL RGL database (Dupuy and Jakob 2018)"
SUFFIXES = (".bsdf",)
OPTIONS = _spectrum.OPTIONS

# Ranks of the fields that every file has.
RANKS = {"theta_i": 1, "phi_i": 1, "ndf": 2, "sigma": 2, "vndf": 4, "jacobian": 1}
MOST_ISOTROPIC_PHI = 2
# A half vector this near to the normal (sine) has no azimuth, only rounding. It gets 0, as in the
# reference implementation; the file's numbers for that direction differ by their noise.
POLE_SINE = 1e-15


def sniff(head: bytes) -> bool:
    """Whether the file is a tensor file."""
    return head.startswith(MAGIC)


def read(path: str | os.PathLike[str], wavelength: str | None = None, illuminant: str | None = None) -> Reflectance:
    """Reads an RGL measurement, isotropic or anisotropic, RGB or spectral.

    **Arguments:**

    - `path`: the file.
    - `wavelength`, `illuminant`: for spectra only; see `_spectrum.channel_weights`.

    **Returns:** one sample for each node of the file whose two directions are above the horizon: its
    value is what was measured there, without interpolation, and its weight 1. Channels may be
    negative, by noise or since the colour is outside Rec. 709: the samples hold 0 there, counted in
    `clamped`; `evaluate` gives the negative number. `evaluate` interpolates as the definition says.

    **Raises:** `FileError` if the file is damaged, a field is missing or of the wrong shape, or no
    node is usable; `UserError` on an option that does not fit.
    """
    fields = read_tensor_file(path)
    _check(path, fields)
    facts = "isotropic" if len(fields["phi_i"]) <= MOST_ISOTROPIC_PHI else "anisotropic"
    if "rgb" not in fields:
        # Interpolation is linear in M, so that spectra may become colours before it.
        weights, done = _spectrum.channel_weights(fields["wavelengths"], wavelength, illuminant)
        fields["rgb"] = np.einsum("pkwyx,wc->pkcyx", fields["spectra"], weights)
        facts = f"{facts}, {done}"
    elif wavelength or illuminant:
        raise UserError(
            f"`{os.path.basename(path)}` holds colours, not spectra. Leave `wavelength` and `illuminant` out, or read "
            "the spectral version of the file."
        )
    try:
        tensors = _Tensors(fields)
    except ValueError as error:
        raise FileError(path, f"field `vndf`: {error}.", "Download the file again.") from error
    wi, wo, value, dropped = tensors.samples()
    if not len(wi):
        raise FileError(
            path,
            f"has no usable node: {', '.join(f'{n} {why}' for why, n in dropped.items())}.",
            "Download the file again.",
        )
    return Reflectance(
        wi=wi,
        wo=wo,
        value=np.maximum(value, 0.0),
        source=f"{os.path.basename(path)} ({NAME}, {facts})",
        format=NAME,
        dropped=dropped,
        clamped=int(np.count_nonzero(value < 0)),
        interpolant=tensors,
    )


def _check(path: str | os.PathLike[str], fields: dict[str, np.ndarray]) -> None:
    """Raises unless the fields are there, fit together and hold numbers."""
    remedy = "This is no RGL material, or it is damaged: download it again."
    reflectance = "rgb" if "rgb" in fields else "spectra"
    ranks = RANKS | {reflectance: 5}
    if reflectance == "spectra":
        ranks["wavelengths"] = 1
    for name, rank in ranks.items():
        if name not in fields:
            shown = "`rgb` or `spectra`" if name == "spectra" else f"`{name}`"
            raise FileError(path, f"has no field {shown}; it has {', '.join(f'`{f}`' for f in fields)}.", remedy)
        if fields[name].ndim != rank or not fields[name].size:
            raise FileError(path, f"field `{name}` has the shape {fields[name].shape}, not {rank} axes.", remedy)
        # Values that are not finite make nodes unusable; the frame they stand in must be whole.
        if name != reflectance and not np.isfinite(fields[name]).all():
            raise FileError(path, f"field `{name}` holds numbers that are not finite.", remedy)
    directions = (len(fields["phi_i"]), len(fields["theta_i"]))
    channels = 3 if reflectance == "rgb" else len(fields["wavelengths"])
    for name, start in (("vndf", directions), (reflectance, (*directions, channels))):
        if fields[name].shape[: len(start)] != start:
            raise FileError(
                path,
                f"field `{name}` has the shape {fields[name].shape}; it must start with {start}, "
                "for `phi_i`, `theta_i`" + (" and channels." if len(start) == 3 else "."),
                remedy,
            )
    for name in ("phi_i", "theta_i", "wavelengths"):
        if name in ranks and (np.diff(fields[name]) <= 0).any():
            raise FileError(path, f"field `{name}` does not ascend.", remedy)
    for name in ("ndf", "sigma", "vndf", reflectance):
        if min(fields[name].shape[-2:]) < 2:
            raise FileError(path, f"field `{name}` has the shape {fields[name].shape}.", remedy)
    for name in ("ndf", "sigma", "vndf"):
        if (fields[name] < 0).any():
            raise FileError(path, f"field `{name}` holds negative numbers.", remedy)


class _Tensors:
    """The definition itself: calling it with (wi, wo) above the horizon gives (n, 3) in 1/sr."""

    def __init__(self, fields: dict[str, np.ndarray]):
        self.axes = (fields["phi_i"].astype(np.float64), fields["theta_i"].astype(np.float64))
        self.isotropic = len(self.axes[0]) <= MOST_ISOTROPIC_PHI
        # How many copies of the measured range of phi_i make a full turn.
        self.reduction = 1 if self.isotropic else int(np.rint(2 * np.pi / (self.axes[0][-1] - self.axes[0][0])))
        self._factored = bool(fields["jacobian"][0])
        self._ndf = fields["ndf"].astype(np.float64)
        self._sigma = fields["sigma"].astype(np.float64)
        self._warp = BilinearWarp(fields["vndf"], self.axes)
        rgb = fields["rgb"].astype(np.float64)
        self._image = rgb.reshape(-1, *rgb.shape[2:])

    def __call__(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        wi, wo = self._reduced(wi, wo)
        phi_i, theta_i = _azimuth(wi), _elevation(wi)
        wm = wi + wo
        u_theta, u_phi = self._square(wm, phi_i)
        x, y = self._warp.invert(u_theta, u_phi, (phi_i, theta_i))
        value = self._measured(x, y, phi_i, theta_i)
        return value * (self._factor(u_theta, u_phi, phi_i, theta_i) / wo[:, 2])[:, None]

    def samples(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, dict[str, int]]:
        """The file's own nodes: wi, wo, value in 1/sr, and reason -> count of those left out."""
        rows, columns = self._image.shape[-2:]
        parts = []
        dropped = {"below horizon": 0, "incidence at the horizon": 0, "not finite": 0}
        for number, image in enumerate(self._image):
            phi_i = self.axes[0][number // len(self.axes[1])]
            theta_i = self.axes[1][number % len(self.axes[1])]
            if np.cos(theta_i) <= HORIZON_COSINE:
                dropped["incidence at the horizon"] += rows * columns
                continue
            u_theta, u_phi = self._warp.warp(number, np.linspace(0, 1, columns), np.linspace(0, 1, rows))
            u_theta, u_phi = u_theta.ravel(), u_phi.ravel()
            theta_m = u_theta**2 * (np.pi / 2)
            phi_m = u_phi * (2 * np.pi) - np.pi + (phi_i if self.isotropic else 0.0)
            wm = spherical(theta_m, phi_m)
            wi = np.broadcast_to(spherical(np.asarray(theta_i), np.asarray(phi_i)), wm.shape)
            wo = 2 * np.einsum("ij,ij->i", wi, wm)[:, None] * wm - wi
            above = wo[:, 2] > HORIZON_COSINE
            one = np.ones(len(wm))
            factor = self._factor(u_theta, u_phi, phi_i * one, theta_i * one)
            with np.errstate(divide="ignore", invalid="ignore"):  # below the horizon; left out
                value = image.reshape(3, -1).T * (factor / wo[:, 2])[:, None]
            finite = np.isfinite(value).all(1)
            keep = above & finite
            dropped["below horizon"] += int(np.count_nonzero(~above))
            dropped["not finite"] += int(np.count_nonzero(above & ~finite))
            parts.append((wi[keep], wo[keep], value[keep]))
        reasons = {reason: count for reason, count in dropped.items() if count}
        if not parts:
            return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)), reasons
        wi, wo, value = (np.concatenate(column) for column in zip(*parts, strict=True))
        return wi, wo, value, reasons

    def _reduced(self, wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Both directions, turned or mirrored to where wi was measured."""
        if self.reduction < 2:
            return wi, wo
        sign_y = np.where(wi[:, 1] > 0, -1.0, 1.0)
        # Half a turn changes both signs together; mirroring changes each on its own.
        sign_x = np.where(wi[:, 0] > 0, -1.0, 1.0) if self.reduction == 4 else sign_y
        signs = np.stack([sign_x, sign_y, np.ones(len(wi))], 1)
        return wi * signs, wo * signs

    def _square(self, wm: np.ndarray, phi_i: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unit coordinates (theta, phi) of half vectors (n, 3) of any length."""
        at_pole = np.hypot(wm[:, 0], wm[:, 1]) <= POLE_SINE
        phi_m = np.where(at_pole, 0.0, _azimuth(wm)) - (phi_i if self.isotropic else 0.0)
        u_phi = (phi_m + np.pi) / (2 * np.pi)
        return np.sqrt(_elevation(wm) * (2 / np.pi)), u_phi - np.floor(u_phi)

    def _factor(self, u_theta: np.ndarray, u_phi: np.ndarray, phi_i: np.ndarray, theta_i: np.ndarray) -> np.ndarray:
        """D(wm) / (4 sigma(wi)), or 1 where the file's numbers hold it already."""
        if not self._factored:
            return np.ones(len(u_theta))
        sigma = bilinear(self._sigma, np.sqrt(theta_i * (2 / np.pi)), (phi_i + np.pi) / (2 * np.pi))
        return bilinear(self._ndf, u_theta, u_phi) / (4 * sigma)

    def _measured(self, x: np.ndarray, y: np.ndarray, phi_i: np.ndarray, theta_i: np.ndarray) -> np.ndarray:
        """(n, 3) M at places of the unit square, linear in all four coordinates."""
        column, s = patch(x, self._image.shape[3])
        row, t = patch(y, self._image.shape[2])
        value = np.zeros((len(x), 3))
        for number, weight in slice_weights(self.axes, (phi_i, theta_i)):
            for row_step, row_share in ((0, 1 - t), (1, t)):
                for column_step, column_share in ((0, 1 - s), (1, s)):
                    share = weight * row_share * column_share
                    corner = self._image[number, :, row + row_step, column + column_step]
                    value += share[:, None] * corner
        return value


def _elevation(direction: np.ndarray) -> np.ndarray:
    return np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), direction[:, 2])


def _azimuth(direction: np.ndarray) -> np.ndarray:
    return np.arctan2(direction[:, 1], direction[:, 0])
