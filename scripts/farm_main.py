# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of scripts/farm."""
from __future__ import annotations

import argparse
import shlex
import os
import sys
from pathlib import Path

import farm_jobs
import farm_openjd
import farm_report
import farm_slurm
import farm_task

RUMPLE = Path(__file__).resolve().parent / "rumple"


def arguments() -> argparse.Namespace:
    top = argparse.ArgumentParser(prog="scripts/farm")
    kinds = top.add_subparsers(dest="command", required=True)
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("files", nargs="+", type=Path, metavar="FILE.blend")
    common.add_argument("--jobs", type=Path, default=Path("rumple-farm"), metavar="DIR",
                        help="new folder for tasks, logs and the report; every node sees it, and the files")
    common.add_argument("--frames", metavar="A-B")
    common.add_argument("--out", type=Path, metavar="DIR", help="folder of the clips")
    common.add_argument("--blender", default="", metavar="PROGRAM", help="the Blender of the nodes")
    common.add_argument("--rumple", default=shlex.quote(str(RUMPLE)), metavar="COMMAND",
                        help="how nodes call Rumple, as words of a shell: 'blender --command rumple' for an installed "
                        "add-on; else this tree")
    common.add_argument("--enable-autoexec", action="store_true")
    kinds.add_parser("openjd", parents=[common], help="write job templates of Open Job Description")
    slurm = kinds.add_parser("slurm", parents=[common], help="write and submit job arrays")
    slurm.add_argument("--sbatch", action="append", default=[], metavar="OPTION",
                       help="for sbatch, as --sbatch=--partition=night; may be given again")
    slurm.add_argument("--pieces", type=int, default=1, metavar="N",
                       help="bake each clip in so many pieces, where its frames allow it, and join them")
    slurm.add_argument("--pre-roll", type=int, default=0, metavar="FRAMES",
                       help="also of frames that go on from one another: so many are solved in front of each piece")
    slurm.add_argument("--tolerance", type=float, metavar="METRES", help="so far apart two pieces may be")
    slurm.add_argument("--dry-run", action="store_true", help="write everything, submit nothing")
    night = kinds.add_parser("simulate", help="a Slurm of its own schedules tasks that sleep in place of bakes")
    night.add_argument("--garments", type=int, default=1000, metavar="N")
    night.add_argument("--workers", type=int, default=200, metavar="N", help="nodes, each bakes one garment at a time")
    night.add_argument("--killed", type=float, default=0.05, metavar="SHARE", help="of the starts die in mid-bake")
    night.add_argument("--broken", type=float, default=0.01, metavar="SHARE", help="of the garments cannot be baked")
    night.add_argument("--nodes-lost", type=int, default=2, metavar="N", help="nodes that die while they bake")
    night.add_argument("--scale", type=float, default=0.3, metavar="FACTOR", help="of a second of the bakes it sleeps")
    night.add_argument("--seed", type=int, default=1)
    night.add_argument("--keep", type=Path, metavar="DIR", help="keep the jobs and their report")
    for name, text in (("report", "write the report now"), ("run", "a task of an array")):
        kind = kinds.add_parser(name, help=text)
        kind.add_argument("jobs", type=Path, metavar="DIR")
        if name == "run":
            kind.add_argument("array", type=int)
    return top.parse_args()


def _say(written: list[Path], jobs: farm_jobs.Jobs) -> int:
    for path in written:
        print(path)
    for file, why in jobs.faults.items():
        print(f"farm: {file} FAILED: {why}", file=sys.stderr)
    return 1 if jobs.faults else 0


def main() -> int:
    chosen = arguments()
    try:
        if chosen.command == "run":
            return farm_task.run(farm_jobs.Jobs.read(chosen.jobs), chosen.array, os.environ)
        if chosen.command == "simulate":
            import farm_simulate  # its Slurm is of the tests: tasks do not wait for it
            return farm_simulate.simulate(chosen)
        if chosen.command == "report":
            return farm_report.write(farm_jobs.Jobs.read(chosen.jobs))
        jobs = farm_jobs.plan(chosen)
        if chosen.command == "openjd":
            return _say(farm_openjd.write(jobs), jobs)
        farm_slurm.write_scripts(jobs, chosen.sbatch)
        if chosen.dry_run:
            print(f"{len(jobs.tasks)} tasks in {len(jobs.arrays)} arrays: {jobs.folder}. Nothing is submitted")
            return 0
        return farm_slurm.submit(jobs)
    except farm_jobs.Refused as error:
        print(f"farm: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
