"""From a model's declaration to its GLSL: parameter structs, uniform block and its bytes, the sum of the lobes.

For `lambert+ggx` the generated text, which a shader includes as `"material"`, reads in essence:

    #define MASKING_SMITH 0
    #define MASKING_SMITH_SEPARABLE 1
    struct lambert_params { vec3 albedo; };
    struct ggx_params { vec3 f0; ... float alpha; ... int masking; ... };
    #include "brdf/lambert.glsl"
    #include "brdf/ggx.glsl"
    layout(std140, binding = 0) uniform Material { vec3 lambert_albedo; vec3 ggx_f0; float ggx_alpha; };
    vec3 lobes(Geometry g) { ... lambert(...) + ggx(ggx_params(ggx_f0, ..., MASKING_SMITH), g) ... }
    vec3 brdf(vec3 wi, vec3 wo) { ... lobes(geometry(wi, wo)) ... }

A static choice enters as a literal, and so does a parameter that the choices leave unused: two lobes of one model may
choose differently, and the compiler removes what was not chosen. So does a weight of 0, with which the lobe that it
scales disappears. All other values live in the block: a new value compiles nothing.

All this follows from plain numbers (`brdf.plain`) and the few facts of `traced`.
"""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from brdf.parameter import Parameter
from brdf.plain import PlainLobe, plain_lobes
from brdf.registry import split

from .table_text import table_text
from .traced import Traced, trace
from .twin import BLOCK, Twin

if TYPE_CHECKING:
    from brdf.model import AbstractBRDF

# Lobe name -> lobe, in the order of the sum.
Lobes = Mapping[str, PlainLobe]

# std140 base alignments and sizes in bytes (OpenGL 4.3, section 7.6.2.2): a vec3 is aligned like a vec4 but leaves the
# fourth float to a following scalar.
_ALIGNMENT = {"scalar": 4, "color": 16}
_GLSL_TYPE = {"scalar": "float", "color": "vec3"}
_BLOCK_ALIGNMENT = 16


@dataclasses.dataclass(frozen=True)
class Member:
    """One value in the uniform block.

    - `name`: lobe and parameter, as in `ggx_2_alpha`.
    - `lobe`: the lobe's name in the sum, as in `ggx_2`.
    - `parameter`: its declaration.
    - `offset`: in bytes from the start of the block.
    """

    name: str
    lobe: str
    parameter: Parameter
    offset: int


def twin(model: AbstractBRDF) -> Twin:
    """What the renderer needs of a model."""
    return twin_of_lobes(plain_lobes(model), {name: trace(lobe) for name, lobe in split(model).items()})


def twin_of_lobes(lobes: Lobes, traced: Mapping[str, Traced]) -> Twin:
    """What the renderer needs of lobes, given what `trace` finds of each."""
    proposals = sum(one.proposals for one in traced.values())
    return Twin(_glsl(lobes, traced), pack(lobes), proposals, is_anisotropic=any(map(_turns, lobes.values())))


def members(lobes: Lobes) -> tuple[Member, ...]:
    """The uniform block in std140 layout, lobes and parameters in their declared order."""
    found: list[Member] = []
    end = 0
    for lobe_name, lobe in lobes.items():
        for parameter in lobe.parameters:
            alignment = _ALIGNMENT[parameter.kind]
            offset = -(-end // alignment) * alignment
            found.append(Member(f"{lobe_name}_{parameter.name}", lobe_name, parameter, offset))
            end = offset + 4 * parameter.size
    return tuple(found)


def block_size(lobes: Lobes) -> int:
    """The size of the uniform block in bytes, a multiple of 16; at least 16, since a buffer cannot be empty."""
    end = max((member.offset + 4 * member.parameter.size for member in members(lobes)), default=0)
    return max(-(-end // _BLOCK_ALIGNMENT) * _BLOCK_ALIGNMENT, _BLOCK_ALIGNMENT)


def pack(lobes: Lobes) -> bytes:
    """The uniform block's bytes for the values of lobes, rounded to float32."""
    block = bytearray(block_size(lobes))
    for member in members(lobes):
        values = np.asarray(lobes[member.lobe].values[member.parameter.name], np.float32).reshape(-1)
        struct.pack_into(f"={member.parameter.size}f", block, member.offset, *values.tolist())
    return bytes(block)


def _turns(lobe: PlainLobe) -> bool:
    """A rotation in use turns a lobe about its normal, unless a strength of the anisotropy is 0."""
    azimuthal = [one for one in lobe.parameters if one.azimuthal]
    strengths = [lobe.values[one.name] for one in azimuthal if one.unit != "rad"]
    return bool(azimuthal) and (not strengths or any(strength.any() for strength in strengths))


def _glsl(lobes: Lobes, traced: Mapping[str, Traced]) -> str:
    """The generated text; it depends on lobes, choices and on which weights are 0, not on other values.

    It defines, with directions in the local frame and values in 1/sr without the cosine,

    - `vec3 lobes(Geometry g)` and `vec3 brdf(vec3 wi, vec3 wo)`,
    - `PROPOSALS`, `float diffuse_proposal(float cos_o)` and `SpecularLobe specular_proposal(int i, float cos_o)`.
    """
    by_model = {lobe.model: lobe for lobe in lobes.values()}
    lines = [*_defines(lobes), '#include "proposals.glsl"', *_tables(traced)]
    for name, lobe in by_model.items():
        lines += [_params_struct(lobe), f'#include "brdf/{name}.glsl"']
    lines.append(_block(lobes))
    calls = [f"{lobe.model}({_params_value(name, lobe)}, g)" for name, lobe in lobes.items()]
    lines += ["vec3 lobes(Geometry g) {", f"    vec3 total = {calls[0]};"]
    lines += [f"    total = total + {call};" for call in calls[1:]]
    lines += ["    return total;", "}"]
    lines += [
        "vec3 brdf(vec3 wi, vec3 wo) {",
        "    if (!above_horizon(wi, wo)) {",
        "        return vec3(0.0);",
        "    }",
        "    return lobes(geometry(wi, wo));",
        "}",
    ]
    return "\n".join([*lines, *_proposals(lobes, traced)]) + "\n"


def _defines(lobes: Lobes) -> list[str]:
    """A number for every option; models that share a choice by name and option share the number."""
    options: dict[str, list[str]] = {}
    for lobe in lobes.values():
        for choice in lobe.declaration.choices:
            known = options.setdefault(choice.name, [])
            known += [option for option in choice.options if option not in known]
    return [
        f"#define {_define(choice, option)} {number}"
        for choice, known in options.items()
        for number, option in enumerate(known)
    ]


def _define(choice_name: str, option: str) -> str:
    return f"{choice_name}_{option}".upper()


def _tables(traced: Mapping[str, Traced]) -> list[str]:
    """The tables of all lobes as functions, the real one where any lobe uses it."""
    found: dict[str, NDArray[np.float64] | None] = {}
    for one in traced.values():
        for name, table in one.tables.items():
            found[name] = table if found.get(name) is None else found[name]
    return [table_text(name, table) for name, table in found.items()]


def _params_struct(lobe: PlainLobe) -> str:
    fields = [f"{_GLSL_TYPE[parameter.kind]} {parameter.name};" for parameter in lobe.declaration.parameters]
    fields += [f"int {choice.name};" for choice in lobe.declaration.choices]
    return f"struct {lobe.model}_params {{ {' '.join(fields)} }};"


def _params_value(lobe_name: str, lobe: PlainLobe) -> str:
    """The struct's value: members of the block; constants for what the choices leave unused and for weights of 0."""
    values = []
    for parameter in lobe.declaration.parameters:
        if not parameter.is_live_under(lobe.options):
            values.append(f"{_GLSL_TYPE[parameter.kind]}({parameter.default:.9e})")
        elif parameter.name in lobe.absent:
            values.append(f"{_GLSL_TYPE[parameter.kind]}(0.0)")
        else:
            values.append(f"{lobe_name}_{parameter.name}")
    values += [_define(choice.name, lobe.options[choice.name]) for choice in lobe.declaration.choices]
    return f"{lobe.model}_params({', '.join(values)})"


def _block(lobes: Lobes) -> str:
    fields = [f"{_GLSL_TYPE[member.parameter.kind]} {member.name};" for member in members(lobes)]
    return f"layout(std140, binding = {BLOCK}) uniform Material {{ {' '.join(fields)} }};" if fields else ""


def _proposals(lobes: Lobes, traced: Mapping[str, Traced]) -> list[str]:
    """The specular lobes as a chain of comparisons, which a compiler folds when the loop over them is unrolled."""
    calls = {name: f"{lobe.model}_proposals({_params_value(name, lobe)}, cos_o)" for name, lobe in lobes.items()}
    total = " + ".join(f"{call}.diffuse" for call in calls.values())
    lines = ["float diffuse_proposal(float cos_o) {", f"    return {total};", "}"]
    specular = [f"{calls[name]}.specular[{n}]" for name in lobes for n in range(traced[name].proposals)]
    lines += [f"#define PROPOSALS {len(specular)}", "SpecularLobe specular_proposal(int i, float cos_o) {"]
    lines += [f"    if (i == {number}) {{ return {one}; }}" for number, one in enumerate(specular)]
    return [*lines, "    return no_proposals().specular[0];", "}"]
