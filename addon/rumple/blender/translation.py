# SPDX-License-Identifier: GPL-3.0-or-later
"""Translates displayed text into Blender's language. translations/ has a file for each language, in gettext format (for
Poedit).

Blender translates labels, tooltips and menus with its own table. Messages are made and printed in English, and said()
translates them for display. In the files {0}, {1}, ... are the values in a message.
"""
from __future__ import annotations

import json
import os
import re
from pathlib import Path

import bpy

from . import compat

FOLDER = Path(os.path.abspath(__file__)).parents[1] / "translations"
OWN_CONTEXT = "Rumple"  # for words that Blender's own translation has with another meaning: a panel of Waves
CONTEXTS = ("*", "Operator", OWN_CONTEXT)
_ALSO_CALLED = {"zh_HANS": ("zh_CN",)}  # before Blender 4.0
_ENTRY = re.compile(r'^msgid (".+")\nmsgstr (".+")$', re.M)
_VALUE = re.compile(r"\{(\d)\}")

_templates: list[tuple[re.Pattern[str], str]] = []


def read(path: Path) -> dict[str, str]:
    """English -> translated, from one file."""
    found = _ENTRY.findall(path.read_text(encoding="utf-8"))
    return {json.loads(english): json.loads(translated) for english, translated in found}


def said(text: str) -> str:
    """A message in Blender's language; unchanged if there is no translation."""
    if bpy.app.translations.locale in ("", "C", "en_US"):
        return text
    whole = compat.translated_report(text)
    return whole if whole != text else _by_template(text)


def _by_template(text: str) -> str:
    for pattern, template in _templates:
        found = pattern.fullmatch(text)
        if found is None:
            continue
        translated = compat.translated_report(template)
        if translated == template:
            return text
        values = [found[f"v{number}"] for number in sorted(set(_VALUE.findall(template)))]
        if template.endswith(f": {{{len(values) - 1}}}") and " " in values[-1]:
            values[-1] = said(values[-1])  # the reason, which is a message itself
        return translated.format(*values)
    return text


def _pattern(template: str) -> re.Pattern[str]:
    """A pattern for the messages made from a template."""
    parts = _VALUE.split(template)  # alternately text and numbers of values
    return re.compile("".join(f"(?P<v{part}>.*?)" if number % 2 else re.escape(part)
                              for number, part in enumerate(parts)), re.S)


def register() -> None:
    table, templates = {}, set()
    for path in FOLDER.glob("*.po"):
        entries = read(path)
        words = {(context, english): text for english, text in entries.items() for context in CONTEXTS}
        for locale in (path.stem, *_ALSO_CALLED.get(path.stem, ())):
            table[locale] = words
        templates |= {english for english in entries if _VALUE.search(english)}
    bpy.app.translations.register(__name__, table)
    # Templates with the most text come first, because "{0}: {1}" matches any message.
    _templates[:] = [(_pattern(template), template)
                     for template in sorted(templates, key=lambda t: (-len(_VALUE.sub("", t)), t))]


def unregister() -> None:
    bpy.app.translations.unregister(__name__)
    _templates.clear()
