"""What is to be seen: plain data, without OpenGL."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import TYPE_CHECKING, Literal, get_args

from brdf.errors import UserError

from .environment import Environment, load_environment
from .mesh import Mesh, sphere
from .twin import Twin, twin_of

if TYPE_CHECKING:
    from brdf.model import AbstractBRDF

_SIZE_MAX = 16384
_SAMPLES_MAX = 1 << 20
_ERROR_MIN = 1e-5
_EXPOSURE_MAX = 64.0

Vector = tuple[float, float, float]
ToneMap = Literal["none", "neutral"]
Sky = Literal["sharp", "blurred", "none"]
Tier = Literal["interactive", "still", "truth"]


@dataclasses.dataclass(frozen=True)
class Camera:
    """A perspective camera; the default one sees the unit sphere in 80 % of the picture's height.

    - `position`, `target`, `up`: world space, y up.
    - `vertical_fov`: radians, in (0, pi).
    """

    position: Vector = (0.0, 0.0, 4.77)
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    vertical_fov: float = math.radians(30)


@dataclasses.dataclass(frozen=True)
class Part:
    """A mesh and what it is made of: a model or sum, or anything else that has been made into a `Twin`."""

    material: AbstractBRDF | Twin
    mesh: Mesh = dataclasses.field(default_factory=sphere)

    @functools.cached_property
    def twin(self) -> Twin:
        """The material as shaders see it."""
        return twin_of(self.material)


@dataclasses.dataclass(frozen=True)
class Scene:
    """Everything that decides a picture.

    - `parts`: at least one; their models may differ.
    - `environment`: the light, and the sky behind the meshes.
    - `rotation`: of the environment about +y in radians, counter-clockwise seen from above.
    - `camera`: the viewer.
    - `exposure`: in stops: the linear picture is multiplied by `2 ** exposure`.
    - `width`, `height`: in pixels.
    - `tier`: how light is gathered. `"interactive"` looks it up in blurred environments (`round_lobes`), `"still"`
      adds up a few jittered frames, `"truth"` goes on until they converge.
    - `error`: `"truth"` only: the RMS error of the picture at which it stops, see `Accumulation.error`. 0.005 unless
      `samples` is given.
    - `seconds`: `"truth"` only: it stops after this time, converged or not.
    - `samples`: directions of light per pixel, all densities and frames together, rounded up to whole frames. With an
      error it is the most, else the exact number: the truth then is a little better, and does not estimate its error.
    - `sky`: whether the environment is seen, as it is or blurred; without it the picture has a fourth channel, the
      coverage.
    - `tone_map`: `"neutral"` adds a picture for displays (Khronos PBR Neutral, sRGB), `"none"` does not.

    Raises `UserError` when a number is outside its range.
    """

    parts: tuple[Part, ...]
    environment: Environment = dataclasses.field(default_factory=lambda: load_environment("studio"))
    rotation: float = 0.0
    camera: Camera = Camera()
    exposure: float = 0.0
    width: int = 512
    height: int = 512
    tier: Tier = "truth"
    error: float | None = None
    seconds: float | None = None
    samples: int | None = None
    sky: Sky = "sharp"
    tone_map: ToneMap = "neutral"

    def __post_init__(self) -> None:
        if not self.parts:
            raise UserError("`parts = ()` draws nothing. Pass at least one `Part`.")
        for name, kind in (("tier", Tier), ("sky", Sky), ("tone_map", ToneMap)):
            if getattr(self, name) not in get_args(kind):
                raise UserError(
                    f"`{name} = {getattr(self, name)!r}` is none of {', '.join(map(repr, get_args(kind)))}."
                )
        self._check_effort()
        for name, value in (("width", self.width), ("height", self.height)):
            if not 1 <= value <= _SIZE_MAX:
                raise UserError(f"`{name} = {value}` is outside [1, {_SIZE_MAX}] pixels. Choose a size in between.")
        if not abs(self.exposure) <= _EXPOSURE_MAX:
            raise UserError(f"`exposure = {self.exposure}` stops is outside [-64, 64]. One stop doubles the light.")
        if not math.isfinite(self.rotation):
            raise UserError(f"`rotation = {self.rotation}` is not an angle. Pass radians.")
        if not 0 < self.camera.vertical_fov < math.pi:
            raise UserError(f"`vertical_fov = {self.camera.vertical_fov}` is outside (0, pi). Pass radians.")

    def _check_effort(self) -> None:
        if self.tier == "interactive" and self.samples is not None:
            raise UserError(
                f"`samples = {self.samples}` is for `tier = 'still'` and `'truth'`; `'interactive'` draws none. "
                "Leave it out or choose another tier."
            )
        for name in ("error", "seconds"):
            if getattr(self, name) is not None and self.tier != "truth":
                raise UserError(
                    f"`{name} = {getattr(self, name)}` is for `tier = 'truth'`, which alone goes on until it is "
                    f"reached; this is `{self.tier!r}`. Leave `{name}` out or ask for the truth."
                )
        if self.error is not None and not _ERROR_MIN <= self.error <= 1:
            raise UserError(f"`error = {self.error}` is outside [{_ERROR_MIN}, 1]. 0.005 is hardly visible.")
        if self.seconds is not None and not 0 < self.seconds < math.inf:
            raise UserError(f"`seconds = {self.seconds}` is no time limit. It must be above 0.")
        if self.samples is not None and not 1 <= self.samples <= _SAMPLES_MAX:
            raise UserError(f"`samples = {self.samples}` is outside [1, {_SAMPLES_MAX}]. A few hundred are usual.")
