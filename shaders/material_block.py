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
"""

from __future__ import annotations

import dataclasses
import struct

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from brdf.chebyshev import Chebyshev
from brdf.model import AbstractBRDF, specialized
from brdf.parameter import Parameter, choices, parameters
from brdf.registry import name_of, split

from .table_text import table_text
from .twin import BLOCK, Twin

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


def members(model: AbstractBRDF) -> tuple[Member, ...]:
    """The uniform block of a model in std140 layout, lobes and parameters in their declared order."""
    found: list[Member] = []
    end = 0
    for lobe_name, lobe in split(model).items():
        for parameter in parameters(lobe):
            alignment = _ALIGNMENT[parameter.kind]
            offset = -(-end // alignment) * alignment
            found.append(Member(f"{lobe_name}_{parameter.name}", lobe_name, parameter, offset))
            end = offset + 4 * parameter.size
    return tuple(found)


def block_size(model: AbstractBRDF) -> int:
    """The size of the uniform block in bytes, a multiple of 16; at least 16, since a buffer cannot be empty."""
    end = max((member.offset + 4 * member.parameter.size for member in members(model)), default=0)
    return max(-(-end // _BLOCK_ALIGNMENT) * _BLOCK_ALIGNMENT, _BLOCK_ALIGNMENT)


def pack(model: AbstractBRDF) -> bytes:
    """The uniform block's bytes for the values of a model, rounded to float32."""
    block = bytearray(block_size(model))
    lobes = split(model)
    for member in members(model):
        values = np.asarray(getattr(lobes[member.lobe], member.parameter.name), np.float32).reshape(-1)
        struct.pack_into(f"={member.parameter.size}f", block, member.offset, *values.tolist())
    return bytes(block)


def twin(model: AbstractBRDF) -> Twin:
    """What the renderer needs of a model: `glsl`, `pack`, `proposal_count` and `is_anisotropic` of it."""
    return Twin(glsl(model), pack(model), proposal_count(model), is_anisotropic=is_anisotropic(model))


def is_anisotropic(model: AbstractBRDF) -> bool:
    """Whether the values of any lobe change when both directions are turned about the normal."""
    return any(_turns(lobe) for lobe in split(model).values())


def _turns(lobe: AbstractBRDF) -> bool:
    """A rotation that its choices leave alive turns a lobe, unless a strength of the anisotropy is 0."""
    azimuthal = [one for one in parameters(lobe) if one.azimuthal and one.is_live(lobe)]
    strengths = [getattr(lobe, one.name) for one in azimuthal if one.unit != "rad"]
    return bool(azimuthal) and (not strengths or any(np.any(strength) for strength in strengths))


def proposal_count(model: AbstractBRDF) -> int:
    """The number of specular lobes that the model proposes to sample, all lobes of a sum together."""
    model = specialized(model)
    # Its value does not matter, nothing is computed; its precision is that of the material's own numbers.
    numbers = (leaf for leaf in jax.tree.leaves(model) if eqx.is_inexact_array(leaf))
    cos_o = jax.ShapeDtypeStruct((), jnp.result_type(*numbers))
    return len(eqx.filter_eval_shape(model.proposals, cos_o).specular)


def glsl(model: AbstractBRDF) -> str:
    """The generated text of a model; it depends on lobes, choices and on which weights are 0, not on other values.

    It defines, with directions in the local frame and values in 1/sr without the cosine,

    - `vec3 lobes(Geometry g)` and `vec3 brdf(vec3 wi, vec3 wo)`,
    - `PROPOSALS`, `float diffuse_proposal(float cos_o)` and `SpecularLobe specular_proposal(int i, float cos_o)`.
    """
    lobes = split(model)
    by_model = {name_of(lobe): lobe for lobe in lobes.values()}
    lines = [*_defines(lobes), '#include "proposals.glsl"', *_tables(lobes)]
    for name, lobe in by_model.items():
        lines += [_params_struct(name, lobe), f'#include "brdf/{name}.glsl"']
    lines.append(_block(model))
    calls = [f"{name_of(lobe)}({_params_value(name, lobe)}, g)" for name, lobe in lobes.items()]
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
    return "\n".join([*lines, *_proposals(lobes)]) + "\n"


def _defines(lobes: dict[str, AbstractBRDF]) -> list[str]:
    """A number for every option; models that share a choice by name and option share the number."""
    options: dict[str, list[str]] = {}
    for lobe in lobes.values():
        for choice in choices(lobe):
            known = options.setdefault(choice.name, [])
            known += [option for option in choice.options if option not in known]
    return [
        f"#define {_define(choice, option)} {number}"
        for choice, known in options.items()
        for number, option in enumerate(known)
    ]


def _define(choice_name: str, option: str) -> str:
    return f"{choice_name}_{option}".upper()


def _tables(lobes: dict[str, AbstractBRDF]) -> list[str]:
    """The tables of all lobes as functions, the real one where any lobe uses it."""
    found: dict[str, Chebyshev | None] = {}
    for lobe in lobes.values():
        for name, table in lobe.tables().items():
            found[name] = found.get(name) or table
    return [table_text(name, table) for name, table in found.items()]


def _params_struct(name: str, lobe: AbstractBRDF) -> str:
    fields = [f"{_GLSL_TYPE[parameter.kind]} {parameter.name};" for parameter in parameters(type(lobe))]
    fields += [f"int {choice.name};" for choice in choices(lobe)]
    return f"struct {name}_params {{ {' '.join(fields)} }};"


def _params_value(lobe_name: str, lobe: AbstractBRDF) -> str:
    """The struct's value: members of the block; constants for what the choices leave unused and for weights of 0."""
    values = []
    for parameter in parameters(type(lobe)):
        if not parameter.is_live(lobe):
            values.append(f"{_GLSL_TYPE[parameter.kind]}({parameter.default:.9e})")
        elif parameter.weight and not np.any(getattr(lobe, parameter.name)):
            values.append(f"{_GLSL_TYPE[parameter.kind]}(0.0)")
        else:
            values.append(f"{lobe_name}_{parameter.name}")
    values += [_define(choice.name, getattr(lobe, choice.name)) for choice in choices(lobe)]
    return f"{name_of(lobe)}_params({', '.join(values)})"


def _block(model: AbstractBRDF) -> str:
    fields = [f"{_GLSL_TYPE[member.parameter.kind]} {member.name};" for member in members(model)]
    return f"layout(std140, binding = {BLOCK}) uniform Material {{ {' '.join(fields)} }};" if fields else ""


def _proposals(lobes: dict[str, AbstractBRDF]) -> list[str]:
    """The specular lobes as a chain of comparisons, which a compiler folds when the loop over them is unrolled."""
    calls = {name: f"{name_of(lobe)}_proposals({_params_value(name, lobe)}, cos_o)" for name, lobe in lobes.items()}
    total = " + ".join(f"{call}.diffuse" for call in calls.values())
    lines = ["float diffuse_proposal(float cos_o) {", f"    return {total};", "}"]
    specular = [f"{calls[name]}.specular[{n}]" for name, lobe in lobes.items() for n in range(proposal_count(lobe))]
    lines += [f"#define PROPOSALS {len(specular)}", "SpecularLobe specular_proposal(int i, float cos_o) {"]
    lines += [f"    if (i == {number}) {{ return {one}; }}" for number, one in enumerate(specular)]
    return [*lines, "    return no_proposals().specular[0];", "}"]
