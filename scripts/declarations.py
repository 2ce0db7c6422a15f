# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes addon/rumple/native/c from native/include: the structs, choices and functions of the C header for ctypes.

Run it after a change of the header. A test compares what it writes with what is there.
"""
from __future__ import annotations

import argparse
import re
import textwrap
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HEADERS = ROOT / "native" / "include" / "rumple"
TARGET = ROOT / "addon" / "rumple" / "native" / "c"
ORDER = ("base", "surface", "base_cloth", "force_fields", "wrinkle_mesh", "wrinkle_layers", "wrinkle_field",
         "wrinkle_field_brush", "wrinkle_paths", "wrinkle_maps")  # each reads only those before it
SCALARS = {"float": "c_float", "double": "c_double", "int32_t": "c_int32", "uint32_t": "c_uint32",
           "uint8_t": "c_uint8", "size_t": "c_size_t", "bool": "c_bool"}
PYTHON = {"c_float": "float", "c_double": "float", "c_bool": "bool", "c_char_p": "bytes | None",
          "c_void_p": "int | None"}


@dataclass
class Header:
    """What one header declares."""

    name: str
    summary: list[str]
    handles: list[str] = field(default_factory=list)
    constants: list[tuple[str, str]] = field(default_factory=list)
    choices: dict[str, list[tuple[str, int]]] = field(default_factory=dict)
    structs: dict[str, list[tuple[str, str, str]]] = field(default_factory=dict)  # name, ctypes type, comment
    functions: dict[str, tuple[str, list[str]]] = field(default_factory=dict)  # result, arguments


def camel(name: str) -> str:
    """rumple_wrinkle_mesh_plan -> WrinkleMeshPlan."""
    return "".join(part.capitalize() for part in name.removeprefix("rumple_").split("_"))


class Reader:
    """Reads headers in their order: what one declares, later ones know."""

    def __init__(self) -> None:
        self.structs: set[str] = set()
        self.handles: set[str] = set()
        self.choices: set[str] = set()

    def read(self, name: str) -> Header:
        text = (HEADERS / f"{name}.h").read_text()
        summary = [line.removeprefix("// ") for line in text.splitlines()[1:] if line.startswith("//")]
        header = Header(name, summary[:_first_code_line(text) - 1])
        for constant, value in re.findall(r"^#define RUMPLE_(\w+) (\"[^\"]*\"|[\d.]+)f?$", text, re.M):
            header.constants.append((constant, value))
        for found in re.finditer(r"typedef enum (\w+) \{(.*?)\}", text, re.S):
            self.choices.add(found[1])
            header.choices[found[1]] = _values(found[2])
        bare = re.sub(r"typedef enum .*?\} \w+;", "", text, flags=re.S)
        for found in re.finditer(r"typedef struct (\w+) (?:\{(.*?)\n\} \1|\1);", bare, re.S):
            if found[2] is None:
                self.handles.add(found[1])
                header.handles.append(found[1])
            else:
                header.structs[found[1]] = self._fields(found[2])
                self.structs.add(found[1])
        code = re.sub(r"//[^\n]*", "", bare)
        for found in re.finditer(r"RUMPLE_API\s+([\w\s*]+?)\s*(rumple_\w+)\(([^)]*)\);", code):
            header.functions[found[2]] = (self._type(found[1]), [
                self._type(re.sub(r"\w+(\[\d*\])?$", lambda end: "*" if end[1] else "", one.strip()))
                for one in found[3].split(",") if one.strip() != "void"])
        return header

    def _fields(self, body: str) -> list[tuple[str, str, str]]:
        fields, before = [], ""
        for line in body.splitlines():
            found = re.match(r"\s*([^/]*?)(\w+)(?:\[(\d+)\])?;(?:\s*// (.*))?$", line)
            if found:
                kind = self._type(found[1])
                fields.append((found[2], f"{kind} * {found[3]}" if found[3] else kind, found[4] or before))
                before = ""
            elif line.strip().startswith("//"):
                comment = line.strip().removeprefix("//").strip()
                if fields and not before and line.index("//") > 8:  # goes on beside the field before it
                    name, kind, said = fields[-1]
                    fields[-1] = (name, kind, f"{said} {comment}")
                else:
                    before = f"{before} {comment}".strip()
        return fields

    def _type(self, c: str) -> str:
        """The ctypes type of one of the header's."""
        stars, name = c.count("*"), re.sub(r"\bconst\b|\bstruct\b|\*", "", c).strip()
        if name == "void":
            return "None"
        if name == "char":
            return "c_char_p" if stars == 1 else "c_void_p"
        if name == "rumple_status":
            return "CHECKED"
        if name in self.handles:
            pointer = f"{camel(name)}Pointer"
            return f"POINTER({pointer})" if stars == 2 else pointer
        if name in self.structs:
            return f"POINTER({camel(name)})" if stars else camel(name)
        return "c_void_p" if stars else SCALARS[name]


def _first_code_line(text: str) -> int:
    """Number of the first line that is no comment."""
    return next(n for n, line in enumerate(text.splitlines()) if not line.startswith("//"))


def _values(body: str) -> list[tuple[str, int]]:
    """(name, number) of an enum, without what all names begin with."""
    found = [(name, int(number)) for name, number in re.findall(r"(\w+) = (\d+)", body)]
    first, last = min(found)[0], max(found)[0]
    same = next((i for i, (a, b) in enumerate(zip(first, last)) if a != b), 0)
    begin = first.rfind("_", 0, same) + 1
    return [(name[begin:], number) for name, number in found]


def python_type(kind: str) -> str:
    """How a field of a struct reads in Python."""
    if " * " in kind:
        return "Array"
    return PYTHON.get(kind, "int" if kind.startswith("c_") else "Any" if "POINTER" in kind or "Pointer" in kind
                      else kind)


def wrapped(text: str, indent: str, after: str = "") -> str:
    return textwrap.fill(text, 118, initial_indent=indent, subsequent_indent=after or indent,
                         break_long_words=False, break_on_hyphens=False)


def struct_lines(name: str, fields: list[tuple[str, str, str]]) -> list[str]:
    lines = ["", "", f"class {camel(name)}(Struct):", f'    """struct {name}"""', "", "    __slots__ = ()"]
    for member, kind, comment in fields:
        line = f"    {member}: {python_type(kind)}"
        if comment and len(line) + len(comment) + 4 > 118:
            lines.append(wrapped(comment, "    # "))
        elif comment:
            line += f"  # {comment}"
        lines.append(line)
    pairs = ", ".join(f'("{member}", {kind})'.replace(" ", "\0") for member, kind, _ in fields)
    lines.append(wrapped(f"_fields_ = ({pairs},)", "    ", "        ").replace("\0", " "))
    return lines


def written(header: Header, before: list[str]) -> str:
    """The Python file of a header."""
    lines = ["# SPDX-License-Identifier: GPL-3.0-or-later",
             '"""' + header.summary[0], *header.summary[1:], "",
             f"Written by scripts/declarations.py from native/include/rumple/{header.name}.h: change that.", '"""',
             "from __future__ import annotations", "",
             "from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,",
             "                    c_uint32, c_void_p)", "from typing import Any", "",
             "from ..struct import CHECKED, Struct, pointer_to"]
    lines += [f"from .{name} import *" for name in before]
    lines.append("")
    lines += [f"{name} = {value}" for name, value in header.constants]
    for name, values in header.choices.items():
        pairs = ", ".join(f'"{key}": {number}' for key, number in values)
        lines.append(wrapped(f"{name.removeprefix('rumple_').upper()} = {{{pairs}}}", "", "    "))
    lines += [f'{camel(name)}Pointer = pointer_to("{name}")' for name in header.handles]
    for name, fields in header.structs.items():
        lines += struct_lines(name, fields)
    lines += ["", "", f"{header.name.upper()}_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {{"]
    for name, (result, arguments) in header.functions.items():
        tail = "," if len(arguments) == 1 else ""
        lines.append(wrapped(f'"{name}": ({result}, ({", ".join(arguments)}{tail})),', "    ", "        "))
    lines.append("}")
    return "\n".join(lines) + "\n"


def index(headers: list[Header]) -> str:
    """The file that knows them all."""
    lines = ["# SPDX-License-Identifier: GPL-3.0-or-later",
             '"""The C header for ctypes. Written by scripts/declarations.py from native/include: change that."""',
             "from __future__ import annotations", "", "from typing import Any", ""]
    lines += [f"from .{header.name} import *" for header in headers]
    structs = [name for header in headers for name in header.structs]
    lines += ["", "FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {",
              *(f"    **{header.name.upper()}_FUNCTIONS," for header in headers), "}",
              "STRUCTS: dict[str, Any] = {", *(f'    "{name}": {camel(name)},' for name in structs), "}"]
    return "\n".join(lines) + "\n"


def files() -> dict[str, str]:
    """Name and text of every file."""
    reader = Reader()
    headers = [reader.read(name) for name in ORDER]
    out = {f"{header.name}.py": written(header, _includes(header.name)) for header in headers}
    return out | {"__init__.py": index(headers)}


def _includes(name: str) -> list[str]:
    return re.findall(r'#include "(\w+)\.h"', (HEADERS / f"{name}.h").read_text())


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()  # without arguments: --help shows this
    for name, text in files().items():
        (TARGET / name).write_text(text)


if __name__ == "__main__":
    main()
