"""The uniform block: its bytes are where GLSL reads them. Oracle: a shader that reads every member back."""

from __future__ import annotations

import dataclasses
import itertools
import struct
from typing import Any

import moderngl
import numpy as np
import pytest

import brdf
from brdf.model import AbstractBRDF
from brdf.parameter import choices, parameters
from brdf.plain import plain_lobes
from brdf.registry import combine, lobe_models, split
from shaders.material_block import block_size, members, pack, twin
from shaders.twin import BLOCK

EXPRESSIONS = [*brdf.MODELS, "lambert+ggx", "oren_nayar+beckmann+ggx", "ggx+ggx+lambert+oren_nayar+ggx"]


def _with_distinct_values(expression: str) -> AbstractBRDF:
    """A model in which no two numbers are equal; they need not be inside any bounds here."""
    counter = itertools.count(1)
    lobes: dict[str, AbstractBRDF] = {}
    for name, lobe in split(brdf.build(expression)).items():
        values: dict[str, Any] = {}
        for parameter in parameters(lobe):
            numbers = [0.5 + next(counter) for _ in range(parameter.size)]
            values[parameter.name] = np.array(numbers) if parameter.kind == "color" else numbers[0]
        lobes[name] = dataclasses.replace(lobe, **values)
    return combine(lobes)


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_members_neither_overlap_nor_cross_a_vec4(expression: str):
    lobes = plain_lobes(brdf.build(expression))
    end = 0
    for member in members(lobes):
        assert member.offset >= end
        assert member.offset // 16 == (member.offset + 4 * member.parameter.size - 1) // 16
        end = member.offset + 4 * member.parameter.size
    assert len(pack(lobes)) == block_size(lobes) >= end
    assert block_size(lobes) % 16 == 0


@pytest.mark.gpu
@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_glsl_reads_every_member_back(expression: str):
    from shaders.context import check, device
    from shaders.program import Programs

    model = _with_distinct_values(expression)
    reads: list[str] = []
    for member in members(plain_lobes(model)):
        parts = [f".{axis}" for axis in "xyz"] if member.parameter.kind == "color" else [""]
        reads += [f"{member.name}{part}" for part in parts]
    body = "".join(f"    found[{number}] = {read};\n" for number, read in enumerate(reads))
    text = (
        "layout(local_size_x = 1) in;\nlayout(std430, binding = 0) writeonly buffer Found { float found[]; };\n"
        f"{twin(model).text}void main() {{\n{body}}}\n"
    )
    ctx = device().ctx
    program = Programs(ctx).compute("text", {}, {"text": text})
    found, block = ctx.buffer(reserve=4 * len(reads)), ctx.buffer(twin(model).block)
    found.bind_to_storage_buffer(0)
    block.bind_to_uniform_block(BLOCK)
    program.run(1)
    ctx.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)
    check(ctx, "reading a block back")
    assert struct.unpack(f"={len(reads)}f", found.read()) == tuple(0.5 + number for number in range(1, len(reads) + 1))


def test_the_text_depends_on_choices_and_not_on_values():
    ggx = brdf.MODELS["ggx"]
    option = choices(ggx)[0].options[1]
    assert twin(ggx(alpha=0.1)).text == twin(ggx(alpha=0.9)).text
    assert twin(ggx()).text != twin(ggx(masking=option)).text


def test_parameters_that_the_choices_leave_unused_are_not_in_the_block():
    names = {member.name for member in members(plain_lobes(brdf.MODELS["ggx"](fresnel="conductor")))}
    assert names == {"ggx_eta", "ggx_k", "ggx_alpha"}


def test_tables_are_real_only_where_a_lobe_uses_them():
    ggx = brdf.MODELS["ggx"]
    assert "ggx_loss(float x, float y) { return 0.0; }" in twin(ggx()).text
    both = combine({"ggx": ggx(), "ggx_2": ggx(energy="multiple")})
    assert "ggx_loss(float x, float y) { return 0.0; }" not in twin(both).text
    assert twin(both).text.count("float ggx_loss(") == 1


def test_every_specular_lobe_is_proposed():
    assert twin(brdf.build("lambert+ggx+beckmann+ggx")).proposals == 3
    assert twin(brdf.build("oren_nayar")).proposals == 0
    assert list(lobe_models("ggx+ggx")) == ["ggx", "ggx_2"]
