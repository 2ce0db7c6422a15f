# SPDX-License-Identifier: GPL-3.0-or-later
"""What is refused is said in a sentence that names the object and says what to do: every one that the sources raise."""
from __future__ import annotations

import ast
import re
import unittest
from pathlib import Path
from typing import Iterator

from rumple.core import wording
from support import sentences

ADDON = Path(__file__).resolve().parents[2] / "addon" / "rumple"
RAISED = frozenset(("UserError", "BakeError"))
OF_FILES = frozenset(("core/poses_json.py",))  # of a file that another program wrote: there is no object
# What has no object: the whole of Blender, or an object that is called otherwise.
WITHOUT_OBJECT = re.compile(
    r"Cycles bakes the maps|GPU Preview of|material \{0\}|it rests on|Bake cancelled|frame \{0\}: ")
ADVICE = re.compile(
    r"(?:^|[:;,.(] |\bor |\band )(?:add|apply|bake|choose|change|connect|delete|enable|free|give|go|let|look|lower|"
    r"make|move|open|paint|press|publish|raise|rename|repair|save|see|set|shorten|show|switch|take|unlock|unwrap|"
    r"update|use|wait|it has to be|expected|there may be)\b", re.IGNORECASE)
DONE = re.compile("is as it was before|the fine mesh is shown")  # nothing is left to be done


def raised(tree: ast.AST) -> Iterator[tuple[str, bool]]:
    """Sentences, and whether their last words are those of another error."""
    for node in ast.walk(tree):
        name = getattr(node.func, "id", getattr(node.func, "attr", "")) if isinstance(node, ast.Call) else ""
        if name in RAISED:
            inside = {id(part) for text in ast.walk(node) if isinstance(text, ast.JoinedStr)
                      for part in ast.walk(text) if part is not text}
            for part in ast.walk(node):
                text = "" if id(part) in inside else sentences.template(part)
                if text:
                    last = part.values[-1] if isinstance(part, ast.JoinedStr) else None
                    yield text, isinstance(last, ast.FormattedValue) and "error" in ast.unparse(last)


class Told(unittest.TestCase):

    def all(self) -> Iterator[tuple[str, str]]:
        for file in ADDON.rglob("*.py"):
            if file.relative_to(ADDON).as_posix() not in OF_FILES:
                for text, passes_on in raised(ast.parse(file.read_text(encoding="utf-8"))):
                    if len(re.findall(r"[a-z]{2,}", re.sub(r"\{\d\}", "", text))) > 1 and not passes_on:
                        yield text, file.name

    def test_it_names_the_object(self) -> None:
        self.assertGreater(len(list(self.all())), 70)
        self.assertEqual([(text, file) for text, file in self.all()
                          if not text.startswith("{0}: ") and not WITHOUT_OBJECT.match(text)], [])

    def test_it_says_what_to_do(self) -> None:
        self.assertEqual([(text, file) for text, file in self.all()
                          if not ADVICE.search(text) and not DONE.search(text)], [])

    def test_what_the_library_refuses_is_told_with_what_to_do(self) -> None:
        self.assertEqual([sentence for _pattern, sentence in wording.SENTENCES if not ADVICE.search(sentence)], [])


if __name__ == "__main__":
    unittest.main()
