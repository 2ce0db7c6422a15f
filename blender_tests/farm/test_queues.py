# SPDX-License-Identifier: GPL-3.0-or-later
"""The job type for Flamenco, run by Node against a stub of its interface, and templates of Open Job Description,
checked by the rules of its published schema and run by a small runner: the clips are those of one machine."""
from __future__ import annotations

import copy
import hashlib
import json
import re
import shutil
import subprocess
import tempfile
import unicodedata
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RUMPLE, FARM = ROOT / "scripts" / "rumple", ROOT / "scripts" / "farm"
JOB_TYPE = ROOT / "scripts" / "flamenco" / "rumple_bake.js"
STUB = ROOT / "blender_tests" / "support" / "flamenco_stub.js"


def said_by(*command: object) -> str:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=120)
    if done.returncode:
        raise AssertionError(f"{command}: {done.stdout}{done.stderr}")
    return done.stdout


class Case(unittest.TestCase):
    """A shot, and its clips by one machine."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.blend = cls.folder / "shot.blend"
        said_by("blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                ROOT / "blender_tests" / "support" / "farm_scene.py", "--", f"{cls.blend}:6")
        said_by(RUMPLE, "bake", cls.blend)
        cls.alone = cls.hashes()
        shutil.rmtree(cls.folder / "rumple")

    def tearDown(self) -> None:
        shutil.rmtree(self.folder / "rumple", ignore_errors=True)

    @classmethod
    def hashes(cls, folder: str = "rumple") -> dict[str, str]:
        """By the names of clips, without the end that depends on the folder."""
        return {path.name.rsplit("-", 1)[0]: hashlib.sha256(path.read_bytes()).hexdigest()
                for path in (cls.folder / folder).iterdir()}


class Flamenco(Case):

    def compiled(self, garments: list[dict], **settings: object) -> dict:
        chosen = dict(garments=json.dumps(garments), frames="", clip_folder="", enable_autoexec=False,
                      blendfile=str(self.blend))
        return json.loads(said_by("node", STUB, JOB_TYPE, json.dumps(chosen | settings)))

    @unittest.skipUnless(shutil.which("node"), "NOT TESTED: there is no Node")
    def test_its_tasks_bake_the_clips_of_one_machine(self) -> None:
        listed = json.loads(said_by(RUMPLE, "list", self.blend, "--json").splitlines()[-1])["garments"]
        job = self.compiled([dict(name=row["name"], needs=row["needs"]) for row in listed])
        tasks = {task["name"]: task for task in job["tasks"]}
        self.assertEqual({name: task["dependencies"] for name, task in tasks.items()},
                         {"bake Sleeve": [], "bake Scarf/.. a": [], "bake Coat": ["bake Sleeve"]})
        for task in job["tasks"]:
            for command in task["commands"]:
                exe, args = command["parameters"]["exe"], command["parameters"]["args"]
                self.assertEqual((exe, args[:2]), ("{blender}", ["--command", "rumple"]))
                said_by(RUMPLE, *args[2:])
        self.assertEqual(self.hashes(), self.alone)
        self.assertEqual(len(self.alone), 3)

    @unittest.skipUnless(shutil.which("node"), "NOT TESTED: there is no Node")
    def test_settings_reach_the_command_and_an_empty_scene_is_refused(self) -> None:
        job = self.compiled([dict(name="A", needs=["not among them"])], frames="2-3", clip_folder="/c",
                            enable_autoexec=True)
        for command in job["tasks"][0]["commands"]:
            self.assertEqual(command["parameters"]["args"][-3:], ["--frames=2-3", "--out=/c", "--enable-autoexec"])
        keys = {setting["key"]: setting for setting in job["settings"]}
        self.assertEqual(keys["garments"]["eval"], "C.scene.rumple_bake_order")
        with self.assertRaisesRegex(AssertionError, "no wrinkled objects"):
            self.compiled([])


# ---------------------------------------------------------------- Open Job Description 2023-09
REFERENCE = re.compile(r"\{\{\s*([\w.]+)\s*\}\}")


class Template:
    """What the schema asks of the parts that ours has. Raises AssertionError."""

    def __init__(self, data: dict) -> None:
        self.data = data
        keys(data, {"specificationVersion", "name", "steps"}, {"parameterDefinitions", "jobEnvironments"})
        assert data["specificationVersion"] == "jobtemplate-2023-09"
        assert 1 <= len(data["parameterDefinitions"]) <= 50
        self.parameters = {}
        for parameter in data["parameterDefinitions"]:
            keys(parameter, {"name", "type"}, {"objectType", "dataFlow", "default"})
            assert re.fullmatch(r"[A-Za-z_]\w{0,63}", parameter["name"]) and parameter["type"] == "PATH"
            assert parameter["objectType"] in ("FILE", "DIRECTORY")
            assert parameter["dataFlow"] in ("NONE", "IN", "OUT", "INOUT")
            self.parameters[f"Param.{parameter['name']}"] = parameter["default"]
        assert not REFERENCE.search(data["name"])  # a path may not be named there
        text(data["name"], 128)
        for environment in data["jobEnvironments"]:
            keys(environment, {"name", "script"})
            text(environment["name"], 64)
            self.action(environment["script"]["actions"]["onEnter"], {})
        self.check_steps(data["steps"])

    def check_steps(self, steps: list[dict]) -> None:
        assert steps and len({step["name"] for step in steps}) == len(steps)
        for step in steps:
            keys(step, {"name", "parameterSpace", "script"}, {"dependencies"})
            text(step["name"], 64)
            waits = [dependency["dependsOn"] for dependency in step.get("dependencies", [])]
            assert "dependencies" not in step or waits
            assert set(waits) <= {other["name"] for other in steps} - {step["name"]}
            (parameter,) = step["parameterSpace"]["taskParameterDefinitions"]
            keys(parameter, {"name", "type", "range"})
            assert parameter["type"] == "STRING" and 1 <= len(parameter["range"]) <= 1024
            for value in parameter["range"]:
                assert 1 <= len(value) <= 1024 and "{{" not in value
                self.action(step["script"]["actions"]["onRun"], {f"Task.Param.{parameter['name']}": value})

    def action(self, action: dict, task: dict[str, str]) -> list[str]:
        """The words of the command."""
        keys(action, {"command"}, {"args", "cancelation"})
        keys(action["cancelation"], {"mode", "notifyPeriodInSeconds"})
        assert action["cancelation"]["mode"] == "NOTIFY_THEN_TERMINATE"
        assert 1 <= action["cancelation"]["notifyPeriodInSeconds"] <= 600
        known = self.parameters | task
        words = [action["command"], *action["args"]]
        for word in words:
            assert all(name in known for name in REFERENCE.findall(word)), word
            assert not any(unicodedata.category(letter) == "Cc" for letter in word)
        return [REFERENCE.sub(lambda found: known[found[1]], word) for word in words]

    def run(self) -> list[str]:
        """All steps, each behind those that it waits for; the garments in the order in which they were baked."""
        for environment in self.data["jobEnvironments"]:
            said_by(*self.action(environment["script"]["actions"]["onEnter"], {}))
        waiting, done, garments = list(self.data["steps"]), set(), []
        while waiting:
            step = next(one for one in waiting if {each["dependsOn"] for each in one.get("dependencies", [])} <= done)
            (parameter,) = step["parameterSpace"]["taskParameterDefinitions"]
            for value in parameter["range"]:
                said_by(*self.action(step["script"]["actions"]["onRun"], {"Task.Param.Garment": value}))
                garments.append(value)
            waiting.remove(step)
            done.add(step["name"])
        return garments


def keys(data: dict, needed: set[str], allowed: set[str] = frozenset()) -> None:
    assert needed <= set(data) <= needed | allowed, sorted(data)


def text(value: str, most: int) -> None:
    assert 1 <= len(value) <= most and not any(unicodedata.category(letter) == "Cc" for letter in value)


class OpenJobDescription(Case):

    def test_its_steps_bake_the_clips_of_one_machine(self) -> None:
        (file,) = said_by(FARM, "openjd", self.blend, "--jobs", self.folder / "jobs", "--out",
                          self.folder / "out").split("\n")[:-1]
        data = json.loads(Path(file).read_text())
        garments = Template(data).run()
        self.assertLess(garments.index("Sleeve"), garments.index("Coat"))
        self.assertEqual(self.hashes("out"), self.alone)
        self.check_that_faults_are_seen(data)

    def check_that_faults_are_seen(self, data: dict) -> None:
        for harm in (lambda one: one.update(more=1), lambda one: one["steps"][0].update(name="x" * 65),
                     lambda one: one["steps"][-1]["dependencies"].clear(),
                     lambda one: one["steps"][0]["script"]["actions"]["onRun"]["args"].append("{{Param.Other}}")):
            harmed = copy.deepcopy(data)
            harm(harmed)
            with self.assertRaises(AssertionError):
                Template(harmed)
