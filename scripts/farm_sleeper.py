# SPDX-License-Identifier: GPL-3.0-or-later
"""What `scripts/farm simulate` has its tasks call in place of `scripts/rumple`: it lists and bakes by sleeping.

FILE is JSON that farm_simulate.py has written. Beside it a garment has NAME.kept, seconds of its bake that a start that
goes on need not do again, and NAME.starts, a line for each start and each death. Standard library only: it is started a
thousand times.
"""
from __future__ import annotations

import json
import os
import random
import signal
import sys
import time
from typing import Any

Shot = dict[str, Any]


def listed(shot: Shot) -> int:
    rows = [dict(name=name, needs=one["needs"], start=1, end=one["samples"], samples=1, bytes=0)
            for name, one in shot["garments"].items()]
    print(json.dumps(dict(garments=rows)))
    return 0


class Bake:
    """Seconds are those that the bake would take; it sleeps `scale` of them."""

    def __init__(self, shot: Shot, place: str, name: str) -> None:
        self.shot, self.one, self.name = shot, shot["garments"][name], name
        self.kept_file, self.log = f"{place}.{name}.kept", f"{place}.{name}.starts"
        self.total = self.one["samples"] * self.one["milliseconds"] / 1e3

    def kept(self) -> float:
        try:
            with open(self.kept_file) as file:
                return float(file.read().split()[0])
        except (OSError, IndexError, ValueError):
            return 0.0

    def note(self, **what: Any) -> None:
        with open(self.log, "a") as file:
            file.write(json.dumps(dict(time=time.time(), **what)) + "\n")

    def keep(self, seconds: float) -> None:
        temporary = f"{self.kept_file}.{os.getpid()}"
        with open(temporary, "w") as file:
            file.write(f"{seconds} {time.time()}")
        os.replace(temporary, self.kept_file)

    def sleep(self, seconds: float) -> None:
        time.sleep(seconds * self.shot["scale"])

    def run(self) -> int:
        start = 0
        if os.path.exists(self.log):
            with open(self.log) as file:
                start = sum("node" in line for line in file)
        self.note(node=os.environ.get("SLURMD_NODENAME", ""))
        self.sleep(self.shot["opening"])
        if self.one["broken"]:
            print(f"Rumple: {self.name} FAILED: nothing is solved: see whether its modifier is on", file=sys.stderr)
            return 1
        done = resumed = self.kept()
        chance = random.Random(f"{self.shot['seed']} {self.name} {start}")
        dies = done + chance.random() * (self.total - done) if chance.random() < self.shot["killed"] else None
        while done < self.total:
            until = min(done + self.shot["checkpoint"], self.total)
            if dies is not None and dies <= until:
                self.sleep(dies - done)
                self.note(lost=dies - done + self.shot["opening"])
                os.kill(os.getpid(), signal.SIGKILL)
            self.sleep(until - done)
            done = until
            if done < self.total:
                self.keep(done)
        share = resumed / self.total
        print(json.dumps(dict(garments={self.name: dict(
            samples=self.one["samples"], seconds=self.total - resumed, bytes=0,
            resumed=int(share * self.one["samples"]), passed=int(share * self.one["samples"]))})))
        return 0


def main() -> int:
    command, place, *words = sys.argv[1:]
    with open(place) as file:
        shot = json.load(file)
    if command == "list":
        return listed(shot)
    name = next(word for word in words if word.startswith("--object=")).removeprefix("--object=")
    return Bake(shot, place, name).run()


if __name__ == "__main__":
    sys.exit(main())
