# SPDX-License-Identifier: GPL-3.0-or-later
"""The previews' shaders ask for nothing that Blender's Vulkan and Metal backends refuse: the interface of every one is
looked at, and its text is compiled for Vulkan, and by a compiler that reads it as Metal would.

No card is asked: in place of `gpu` stands what writes down.
"""
from __future__ import annotations

import contextlib
import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from mathutils import Matrix
from rumple.blender.viewport import (glsl, gpu_arrays, gpu_kernels, gpu_mesh, preview, preview_field, preview_mesh,
                                     preview_paths, proxy_layer, studio_light)
from rumple.core.base.wording import UserError
from support import sleeve

SHADERS = Path(__file__).resolve().parents[2] / "shaders" / "preview"
METAL = (Path(__file__).resolve().parents[1] / "support" / "metal.h").read_text(encoding="utf-8")
# Bytes and alignment of std140 and std430; what is not here has gaps that differ between systems.
SIZES = {"FLOAT": (4, 4), "INT": (4, 4), "BOOL": (4, 4), "VEC2": (8, 8), "IVEC2": (8, 8), "VEC4": (16, 16),
         "IVEC4": (16, 16), "MAT4": (64, 16)}
MOST_CONSTANT_BYTES = 128   # that every Vulkan has
MOST_SAMPLERS = 16          # of a stage in Metal
MOST_BETWEEN = 60           # numbers from stage to stage that every OpenGL 3.3 has
# What stands before a name that is declared: a type, and perhaps another name.
DECLARED = r"\b(?:float|int|bool|[iu]?vec[234]|mat[234]|[A-Z]\w+)\s+(?:\w+\s*,\s*)?"


class Recorder:
    """Whatever is said to a GPUShaderCreateInfo or GPUStageInterfaceInfo."""

    def __init__(self, name: str = "") -> None:
        self.said: dict[str, list[tuple]] = {}

    def __getattr__(self, word: str) -> Any:
        return lambda *arguments, **named: self.said.setdefault(word, []).append((*arguments, *named.values()))

    def all(self, word: str) -> list[tuple]:
        return self.said.get(word, [])

    def stages(self) -> list[str]:
        return [stage for stage in ("vertex", "fragment", "compute") if self.all(f"{stage}_source")]

    def text(self, stage: str) -> str:
        """Empty if it has no such stage."""
        return "".join(text for (text,) in self.all(f"{stage}_source"))

    def between(self) -> list[tuple[str, str, str]]:
        """What goes from stage to stage: (how, type, name)."""
        return [(how, *said) for (stages,) in self.all("vertex_out") for how in ("smooth", "flat")
                for said in stages.all(how)]


def recorded(recorder: type[Recorder] = Recorder) -> list[Recorder]:
    """Every shader of the previews."""
    made: list[Recorder] = []
    fake = mock.MagicMock()
    fake.types.GPUShaderCreateInfo = fake.types.GPUStageInterfaceInfo = recorder
    fake.shader.create_from_info = made.append
    with contextlib.ExitStack() as patches:
        for module in (gpu_arrays, gpu_kernels, preview_field, preview_mesh, preview_paths, proxy_layer):
            patches.enter_context(mock.patch.object(module, "gpu", fake))
        for compile_it in (preview_field.Passes, gpu_mesh.Kernels, preview_field._compile, preview_mesh._compile,
                           preview_paths._compile, proxy_layer._proxy_shader, proxy_layer._composite_shader):
            compile_it()
    return made


def without_comments(text: str) -> str:
    return re.sub(r"//[^\n]*", "", text)


def block_members() -> list[tuple[str, int]]:
    """(TYPE, how many) of preview_block.glsl."""
    body = re.search(r"\{(.*)\}", without_comments(glsl.text("preview/preview_block")), re.S)
    assert body
    return [(kind.upper(), int(count or 1)) for kind, count in re.findall(r"(\w+)\s+\w+(?:\[(\d+)\])?;", body[1])]


class Older(Recorder):
    """Blender 4.3 and before: a shader that writes depth cannot be told from others."""

    def __getattr__(self, word: str) -> Any:
        if word == "depth_write":
            raise AttributeError(word)
        return super().__getattr__(word)


class Interfaces(unittest.TestCase):
    shaders: list[Recorder]

    @classmethod
    def setUpClass(cls) -> None:
        cls.shaders = recorded()
        if len(cls.shaders) < 4 or not any(shader.between() for shader in cls.shaders):
            raise AssertionError("the shaders of the previews were not recorded: nothing would be tested")

    def test_every_file_is_in_one_of_them(self) -> None:
        together = "".join(shader.text(stage) for shader in self.shaders for stage in shader.stages())
        files = list(SHADERS.glob("*.glsl"))
        self.assertGreater(len(files), len(self.shaders))
        for file in files:
            if file.name != "preview_block.glsl":
                self.assertIn(file.read_text(encoding="utf-8"), together, file.name)

    def test_push_constants_fit_everywhere(self) -> None:
        self.assertTrue(any(shader.all("push_constant") for shader in self.shaders))
        for shader in self.shaders:
            end = 0
            for kind, _name in shader.all("push_constant"):
                size, alignment = SIZES[kind]
                end = -(-end // alignment) * alignment + size
            self.assertLessEqual(end, MOST_CONSTANT_BYTES)

    def test_a_push_constant_shares_its_name_with_nothing(self) -> None:
        """Vulkan and Metal have it as a macro: a local of its name would not compile there."""
        for shader in self.shaders:
            for _kind, name in shader.all("push_constant"):
                for stage in shader.stages():
                    declared = re.search(DECLARED + rf"{name}\b", without_comments(shader.text(stage)))
                    self.assertIsNone(declared, declared)

    def test_the_block_is_laid_out_as_it_is_filled(self) -> None:
        """std140 leaves no gap, and what Python fills has its size."""
        end = 0
        for kind, count in block_members():
            size, alignment = SIZES[kind]
            self.assertEqual(end % alignment, 0, "std140 leaves a gap before it")
            self.assertTrue(count == 1 or size % 16 == 0, "std140 widens the elements of an array")
            end += count * size
        self.assertEqual(end % 16, 0)
        obj = sleeve.scene(wrinkles=False)
        shading = mock.MagicMock(light="FLAT", color_type="SINGLE", single_color=(1.0, 1.0, 1.0))
        with mock.patch.object(preview, "gpu") as fake:
            fake.state.viewport_get.return_value = (0, 0, 400, 300)
            preview._block(obj, Matrix(), Matrix(), studio_light.lights(shading, Matrix()),
                           studio_light.finish(obj, 0, shading))
        self.assertEqual(4 * fake.types.Buffer.call_args.args[1], end)

    def test_whole_numbers_are_not_interpolated_and_all_is_few(self) -> None:
        for shader in self.shaders:
            numbers = 0
            for how, kind, name in shader.between():
                self.assertFalse(how == "smooth" and kind.startswith(("I", "U", "B")), name)
                self.assertFalse(kind.startswith("MAT"), name)
                numbers += int(kind[-1]) if kind[-1].isdigit() else 1
            self.assertLessEqual(numbers, MOST_BETWEEN)
            self.assertLessEqual(len(shader.all("sampler")), MOST_SAMPLERS)
            self.assertLessEqual(len(shader.all("fragment_out")), 4)

    def test_what_the_shader_writes_besides_colour_is_said(self) -> None:
        """Metal has no gl_FragDepth where that was not said; Blender 3.4 knows no word for it."""
        for shader in self.shaders:
            self.assertEqual("gl_FragDepth" in shader.text("fragment"), bool(shader.all("depth_write")))

    def test_depth_is_written_where_blender_has_no_word_for_it(self) -> None:
        """Blender 4.3 declares every gl_FragDepth as layout(depth_unchanged). Software GL writes it all the same; on an
        NVIDIA card what stood before the folds did not hide them."""
        writing = [shader for shader in recorded(Older) if "gl_FragDepth" in shader.text("fragment")]
        self.assertEqual([shader.all("define") for shader in writing], [[("depth_unchanged", "depth_any")]])

    def test_metal_refuses_it_in_words_there(self) -> None:
        """It declares gl_FragDepth only where that was said: the shader did not compile on any Mac with 4.3."""
        with mock.patch.object(gpu_arrays, "backend", return_value="METAL"), \
                self.assertRaisesRegex(UserError, "needs a later Blender on macOS"):
            recorded(Older)

    def test_vulkan_reads_overlays_that_are_linear(self) -> None:
        """It makes them so while it reads, OpenGL and Metal do not: their colours were made linear twice."""
        for backend, form in (("OPENGL", "RGBA8"), ("METAL", "RGBA8"), ("VULKAN", "RGBA16F")):
            with mock.patch.object(gpu_arrays, "gpu") as fake:
                fake.state.viewport_get.return_value = (0, 0, 400, 300)
                fake.platform.backend_type_get.return_value = backend
                over, shader = gpu_arrays.overlays((3, 4, 20, 10)), mock.MagicMock()
                over.bind(shader)
                self.assertEqual(fake.types.GPUTexture.call_args.kwargs["format"], form)
            shader.uniform_int.assert_called_with("overlays_are_linear", backend == "VULKAN")

    def test_nothing_is_declared_in_the_text(self) -> None:
        for shader in self.shaders:
            for stage in shader.stages():
                found = re.search(r"#version|#extension|\b(layout|uniform|varying|attribute|texture[123]D)\b|"
                                  r"\bgl_(FragColor|FragData|PointSize)", without_comments(shader.text(stage)))
                self.assertIsNone(found, found)

    @unittest.skipUnless(shutil.which("glslangValidator"), "there is no glslangValidator")
    def test_it_compiles_for_vulkan(self) -> None:
        for shader in self.shaders:
            for stage in shader.stages():
                self.compiles(for_vulkan(shader, stage), "glslangValidator", "--stdin", "-o", os.devnull,
                              "--target-env", "vulkan1.2", "-S", stage[:4])

    @unittest.skipUnless(shutil.which("clang++"), "there is no clang++")
    def test_metal_would_read_it(self) -> None:
        """All in one text, each in a class of its own, as Blender's Metal backend does it."""
        self.compiles(METAL + "".join(for_metal(shader, stage, f"{stage}_{i}") for i, shader in enumerate(self.shaders)
                                      for stage in shader.stages()),
                      "clang++", "-x", "c++", "-std=c++14", "-pedantic-errors", "-Wno-vla-extension", "-Wno-gnu",
                      "-fno-builtin", "-nostdinc", "-fsyntax-only", "-ferror-limit=40", "-")

    def compiles(self, text: str, *command: str) -> None:
        run = subprocess.run(command, input=text, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(run.returncode, 0, run.stdout)


def for_vulkan(shader: Recorder, stage: str) -> str:
    """As Blender's Vulkan backend declares it."""
    lines = ["#version 450"]
    lines += [text for (text,) in shader.all("typedef_source")]
    lines += [f"layout(binding = {16 + slot}, std140) uniform _{name} {{ {kind} {name}; }};"
              for slot, kind, name in shader.all("uniform_buf")]
    lines += [f"layout(binding = {slot}) uniform sampler2D {name};" for slot, _kind, name in shader.all("sampler")]
    constants = shader.all("push_constant")
    if constants:
        members = " ".join(f"{kind.lower()} pc_{name};" for kind, name in constants)
        lines.append(f"layout(push_constant) uniform constants {{ {members} }} PushConstants;")
        lines += [f"#define {name} (PushConstants.pc_{name})" for _kind, name in constants]
    lines += [f"layout(local_size_x = {size}) in;" for (size,) in shader.all("local_group_size")]
    lines += [f"layout(binding = {24 + slot}, {form.lower()}) uniform {access_of(access)} image2D {name};"
              for slot, form, _kind, name, access in shader.all("image")]
    here, there = ("vertex_in", "out") if stage == "vertex" else ("fragment_out", "in")
    lines += [f"layout(location = {slot}) {'in' if stage == 'vertex' else 'out'} {kind.lower()} {name};"
              for slot, kind, name in shader.all(here)]
    lines += [f"layout(location = {i}) {there} {how} {kind.lower()} {name};"
              for i, (how, kind, name) in enumerate(shader.between())]
    return "\n".join(lines) + "\n" + shader.text(stage)


def access_of(access: set[str]) -> str:
    return "" if access == {"READ", "WRITE"} else "writeonly" if access == {"WRITE"} else "readonly"


WORDS = ("FORMULA", "REAL", "BOOL", "TEXEL", "THIS_TEXEL", "READ", "WRITE")  # macros of our own texts


def for_metal(shader: Recorder, stage: str, name: str) -> str:
    """A class with everything in it; push constants and blocks are macros, parameters that are written references."""
    text = re.sub(r"\b(?:in)?out (\w+) (\w+)", r"\1 &\2", without_comments(shader.text(stage)))
    text = re.sub(r"\b([iu]?vec[234]|mat[234])\(", r"make_\1(", re.sub(r"\bmain\(", "main_of_stage(", text))
    constants, blocks = shader.all("push_constant"), shader.all("uniform_buf")
    own = [(kind, word) for _slot, kind, word in shader.all("vertex_in" if stage == "vertex" else "fragment_out")]
    members = [(kind.lower(), word) for kind, word in own + [(kind, word) for _how, kind, word in shader.between()]]
    members += [("sampler2D", word) for _slot, _kind, word in shader.all("sampler")]
    members += [("image2D", word) for _slot, _form, _kind, word, _access in shader.all("image")]
    members += [(kind, f"*_{word}") for _slot, kind, word in blocks]
    macros = {word: f"global_uniforms->{word}" for _kind, word in constants}
    macros |= {word: f"(*_{word})" for _slot, _kind, word in blocks}
    return "\n".join([
        f"struct uniforms_{name} {{", *(f"{kind.lower()} {word};" for kind, word in constants), "};",
        f"struct {name} {{", *(without_comments(types) for (types,) in shader.all("typedef_source")),
        f"uniforms_{name} *global_uniforms;",
        "vec4 gl_Position, gl_FragCoord; bool gl_FrontFacing; ivec3 gl_GlobalInvocationID;",
        "float gl_FragDepth;" if shader.all("depth_write") else "",
        *(f"{kind} {word};" for kind, word in members), *(f"#define {word} {meant}" for word, meant in macros.items()),
        text, "};", *(f"#undef {word}" for word in (*macros, *WORDS)), ""])


if __name__ == "__main__":
    unittest.main()
