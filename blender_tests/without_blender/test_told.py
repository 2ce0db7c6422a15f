# SPDX-License-Identifier: GPL-3.0-or-later
"""What is refused is said in a sentence that names the object and says what to do: every one that the sources raise."""
from __future__ import annotations

import ast
import re
import unittest
from pathlib import Path
from typing import Iterator

from rumple.core.base import wording
from support import sentences

ADDON = Path(__file__).resolve().parents[2] / "addon" / "rumple"
RAISED = frozenset(("UserError", "BakeError"))
OF_FILES = frozenset(("core/systems/poses_json.py",))  # of a file that another program wrote: there is no object
# What has no object: the whole of Blender, or an object that is called otherwise.
WITHOUT_OBJECT = re.compile(
    r"Cycles bakes the maps|GPU Preview of|material \{0\}|it rests on|Bake cancelled|frame \{0\}: ")
ADVICE = re.compile(
    r"(?:^|[:;,.(] |\bor |\band )(?:add|apply|bake|choose|change|connect|delete|enable|free|give|go|leave|let|look|"
    r"lower|make|move|open|paint|press|publish|raise|rename|repair|save|see|set|shorten|show|switch|take|unlock|unwrap|"
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

    def test_no_name_of_an_array_is_left(self) -> None:
        """What the library says of what artists can have: each reached the panel as it stands here."""
        for raw, expected in (
                ("positions_rest: vertex 5 is 1e+12 away from the origin, more than 1e+08: move the mesh to the "
                 "origin, or scale it down", "Rag: vertex 5 is 1e+12 away from the origin at rest"),
                ("radius: number 0: expected 0 to 1, got nan", "Rag: what is painted as radius holds nan, where 0"),
                ("mask: number 7: expected 0 to 1000, got -5", "Rag: what is painted as mask holds -5, where 0"),
                ("room: expected 0 to 1e+09, got 3e+10", "Rag: room is 3e+10 in units of the object, where 0 to 1e+09"),
                ("width: expected a value above 0 to 1e+06, got 0", "Rag: width is 0 in units of the object, where 0"),
                ("width: folds of 1e-05 can start at more than 100000 places of this mesh, and a frame would take "
                 "minutes: raise the width", "Rag: folds of 1e-05 can start at more than 100000 places of this mesh"),
                ("world_from_object: it has no inverse, or is not finite", "Rag: its scale is zero in this frame"),
                ("segments: 40000 make more corners than can be counted", "Rag: 40000 segments make more corners"),
                ("levels: 12 levels make more corners than can be counted", "Rag: 12 levels make more corners"),
                ("positions: the frame is so far from the rest shape, or a setting so extreme, that its result is not "
                 "finite", "Rag: this frame is so far from the rest shape"),
                ("OpenSubdiv cannot refine this mesh", "Rag: its faces cannot be subdivided")):
            said = str(wording.user_error("Rag", ValueError(raw)))
            self.assertTrue(said.startswith(expected), said)
            self.assertNotRegex(said, r"\w_\w|: \w+: ")


if __name__ == "__main__":
    unittest.main()
