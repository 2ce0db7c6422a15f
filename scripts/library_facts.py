# SPDX-License-Identifier: GPL-3.0-or-later
"""What a built library asks of its system, what it exports, and whether it is signed.

    library_facts.py FILE...    of rumple.dll, librumple.so or librumple.dylib, for docs/platforms.md

Package tests compare the facts of what is in the zips with what every machine has.
"""
from __future__ import annotations

import re
import struct
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Facts:
    needs: list[str] = field(default_factory=list)      # libraries of the system
    exports: list[str] = field(default_factory=list)    # names, without the underscore of macOS
    asks: list[str] = field(default_factory=list)       # functions of the system that it calls; not of Windows
    system: str = ""                                    # the oldest one: "glibc 2.28", "macOS 11.0"
    processor: str = ""
    signed: bool | None = None                          # macOS: whether it has a signature that covers it
    faults: list[str] = field(default_factory=list)     # what a system may refuse

    def mathematics(self) -> list[str]:
        """Those that it calls whose last bit differs between systems."""
        differ = re.compile(r"_*(a?(sin|cos|tan)h?|atan2|sincos|exp2?|expm1|log(2|10|1p)?|pow|cbrt|hypot|erfc?|"
                            r"[tl]gamma|c(sqrt|exp|log|pow|arg|abs))[fl]?(_stret)?")
        return sorted(name for name in self.asks if differ.fullmatch(name))


def facts_of(path: Path) -> Facts:
    """Raises ValueError where it is no library of the three systems."""
    head = path.read_bytes()[:4]
    if head == b"\x7fELF":
        return _elf(path)
    if head[:2] == b"MZ":
        return _windows(path)
    if head == b"\xcf\xfa\xed\xfe":
        return _macos(path.read_bytes())
    raise ValueError(f"{path}: no library of Linux, Windows or macOS")


def _output(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def _elf(path: Path) -> Facts:
    dynamic, symbols = _output("objdump", "-p", str(path)), _output("objdump", "-T", str(path))
    versions = [tuple(map(int, version.split("."))) for version in re.findall(r"GLIBC_([\d.]+)", dynamic + symbols)]
    exports = [line.split()[-1] for line in symbols.splitlines()
               if "*UND*" not in line and re.match(r"[\da-f]{16}", line)]
    asks = [line.split()[-1] for line in symbols.splitlines() if "*UND*" in line]
    return Facts(needs=re.findall(r"NEEDED\s+(\S+)", dynamic), exports=exports, asks=asks, processor="x86-64",
                 system="glibc " + ".".join(map(str, max(versions, default=(0,)))))


def _windows(path: Path) -> Facts:
    said = _output("x86_64-w64-mingw32-objdump", "-p", str(path))
    table = said[said.index("[Ordinal/Name Pointer] Table"):]
    return Facts(needs=re.findall(r"DLL Name: (\S+)", said), processor="x86-64", system="Windows",
                 exports=re.findall(r"^\t\[ *\d+\] (?:\+base\[ *\d+\] +\w+ )?(\w+)$", table.split("\n\n")[0], re.M))


def _macos(data: bytes) -> Facts:
    """Load commands: <mach-o/loader.h>."""
    processor, _kind, _file, count = struct.unpack_from("<4I", data, 4)
    facts = Facts(processor={0x0100000C: "arm64", 0x01000007: "x86-64"}.get(processor, hex(processor)), signed=False)
    at = 32
    for _ in range(count):
        command, size = struct.unpack_from("<2I", data, at)
        if command in (0xC, 0x80000018, 0x8000001F):    # LC_LOAD_DYLIB, weak, re-exported
            name = at + struct.unpack_from("<I", data, at + 8)[0]
            facts.needs.append(data[name:data.index(b"\0", name)].decode())
        elif command == 0x32:       # LC_BUILD_VERSION
            oldest = struct.unpack_from("<2I", data, at + 8)[1]
            facts.system = f"macOS {oldest >> 16}.{oldest >> 8 & 255}"
        elif command == 0xD:        # LC_ID_DYLIB
            if not data.startswith(b"@rpath/", at + struct.unpack_from("<I", data, at + 8)[0]):
                facts.faults.append("it names the folder where it was built")
        elif command in (0x22, 0x80000022):     # LC_DYLD_INFO, LC_DYLD_INFO_ONLY
            facts.exports = _trie(data, *struct.unpack_from("<2I", data, at + 40))
            if struct.unpack_from("<I", data, at + 28)[0]:
                facts.faults.append("what it has of C++ may be replaced by that of others")
        elif command == 0x80000033:     # LC_DYLD_EXPORTS_TRIE
            facts.exports = _trie(data, *struct.unpack_from("<2I", data, at + 8))
        elif command == 0x2:        # LC_SYMTAB
            facts.asks = _macos_undefined(data, *struct.unpack_from("<3I", data, at + 8))
            if struct.unpack_from("<I", data, at + 16)[0] % 8:
                facts.faults.append("the strings of its symbols are not aligned")
        elif command == 0x1D:       # LC_CODE_SIGNATURE
            start, length = struct.unpack_from("<2I", data, at + 8)
            facts.signed = start + length <= len(data) and data[start:start + 4] == b"\xfa\xde\x0c\xc0"
        at += size
    return facts


def _macos_undefined(data: bytes, symbols: int, count: int, strings: int) -> list[str]:
    names = []
    for i in range(count):
        name, kind = struct.unpack_from("<IB", data, symbols + 16 * i)
        if kind & 0x01 and not kind & 0xEE:     # external, undefined, nothing for debuggers
            start = strings + name
            names.append(data[start:data.index(b"\0", start)].decode().removeprefix("_"))
    return names


def _trie(data: bytes, start: int, size: int) -> list[str]:
    """What macOS finds by its name: <mach-o/loader.h>, the tree of exported symbols."""
    def number(at: int) -> tuple[int, int]:
        value = shift = 0
        while True:
            byte = data[at]
            value, shift, at = value | (byte & 0x7F) << shift, shift + 7, at + 1
            if byte < 0x80:
                return value, at

    names, nodes = [], [(0, "")] if size else []
    while nodes:
        node, name = nodes.pop()
        length, at = number(start + node)
        if length:
            names.append(name.removeprefix("_"))
        at += length
        for _ in range(data[at]):
            end = data.index(b"\0", at + 1)
            child, following = number(end + 1)
            nodes.append((child, name + data[at + 1:end].decode()))
            at = following - 1
    return names


if __name__ == "__main__":
    for file in map(Path, sys.argv[1:]):
        found = facts_of(file)
        foreign = [name for name in found.exports if not name.startswith("rumple_")]
        print(f"{file}: {file.stat().st_size / 1e6:.2f} MB, {found.processor}, {found.system}, needs {found.needs}, "
              f"exports {len(found.exports)}, of others {len(foreign)} {foreign[:5]}, signed {found.signed}, "
              f"faults {found.faults}, mathematics of the system {found.mathematics()}")
