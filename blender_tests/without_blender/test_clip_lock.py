# SPDX-License-Identifier: GPL-3.0-or-later
"""The lock of a clip: one holder, whoever is gone gives it up, and what came to nothing leaves nothing."""
from __future__ import annotations

import ctypes
import errno
import json
import os
import tempfile
import threading
import time
import unittest
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any, Iterator
from unittest import mock

from rumple.core.files import clip_folder, clip_lock
from rumple.core.files.clip_lock import Held, Holder, Lock
from rumple.core.files.clip_manifest import ClipFault


class Kernel:
    """What Windows says of a process: refused is the error of opening it, else is_over says whether it has ended."""

    def __init__(self, refused: int = 0, is_over: bool = False, made: int = 7) -> None:
        self.closed: list[int] = []
        self.OpenProcess = mock.Mock(return_value=None if refused else 1 << 40)
        self.WaitForSingleObject = mock.Mock(return_value=0 if is_over else 0x102)
        self.GetProcessTimes = mock.Mock(side_effect=lambda _handle, at, *_others: self._tell(at, made))
        self.CloseHandle = mock.Mock(side_effect=self.closed.append)
        self.error = refused

    @staticmethod
    def _tell(at: Any, made: int) -> bool:
        at._obj.value = made
        return True

    @contextmanager
    def running(self) -> Iterator[None]:
        """As if this were Windows. No path can be made meanwhile."""
        kernel32 = dict(WinDLL=mock.Mock(return_value=self), get_last_error=mock.Mock(return_value=self.error))
        with mock.patch.multiple(ctypes, create=True, **kernel32), mock.patch.object(os, "name", "nt"):
            yield


class InContainers(unittest.TestCase):

    def test_two_of_one_name_do_not_take_their_clips_from_each_other(self) -> None:
        """Each has numbers of its own for processes: one that lives in the other looked like one that is gone."""
        with mock.patch.object(os, "readlink", return_value="pid:[4026532178]"):
            other = clip_folder._host()
        self.assertNotEqual(other, clip_folder.HOST)
        with tempfile.TemporaryDirectory() as folder:
            clip = Path(folder, "a.pc2")
            with mock.patch.object(clip_folder, "HOST", other), mock.patch.object(os, "getpid", return_value=1 << 29):
                held, part = Lock(clip), clip_folder.temporary(clip)
            part.touch()
            with self.assertRaisesRegex(Held, "is being baked by process"):
                Lock(clip)
            clip_folder.sweep(Path(folder))
            self.assertTrue(part.exists())
            held.check()
            with mock.patch.object(os, "readlink", return_value="pid:[4026531836]"):
                self.assertRegex(clip_folder._host(), r"^[A-Za-z0-9_]+$")
            with mock.patch.object(os, "readlink", side_effect=FileNotFoundError):  # no Linux
                self.assertTrue(other.startswith(clip_folder._host()))


class OnWindows(unittest.TestCase):

    def test_a_process_that_is_over_does_not_run_and_one_that_may_not_be_opened_does(self) -> None:
        """What crashed counted as running while a queue had its handle, and a process of another user as gone."""
        for kernel, is_running in ((Kernel(), True), (Kernel(is_over=True), False), (Kernel(refused=87), False),
                                   (Kernel(refused=5), True)):  # 87: there is none of that number
            with kernel.running():
                self.assertEqual(clip_folder.is_running(4711), is_running)
            self.assertEqual(len(kernel.closed), 0 if kernel.error else 1)

    def test_of_a_holder_that_is_gone_the_lock_is_taken_over(self) -> None:
        for kernel, is_gone in ((Kernel(), False), (Kernel(is_over=True), True), (Kernel(refused=87), True),
                                (Kernel(refused=5), False), (Kernel(made=8), True)):  # its number came again
            with kernel.running():
                holder = Holder(clip_folder.HOST, 4711, "7", "")
                self.assertEqual(holder.is_gone(), is_gone)
            self.assertEqual(len(kernel.closed), 0 if kernel.error else kernel.OpenProcess.call_count)

    def test_a_lock_says_when_its_process_was_made(self) -> None:
        with Kernel(made=1 << 60).running():
            self.assertEqual(Holder.here().started, str(1 << 60))


@unittest.skipUnless(os.path.exists("/proc/self/comm"), "of Linux")
class OnLinux(unittest.TestCase):

    def test_a_process_whose_name_is_cut_inside_a_character_is_recognised(self) -> None:
        """Linux keeps 15 bytes of it."""
        name = Path("/proc/self/comm")
        former, started = name.read_bytes(), Holder.here().started
        name.write_bytes(b"blender-caf\xc3")
        self.addCleanup(name.write_bytes, former)
        self.assertNotEqual(started, "")
        self.assertEqual(Holder.here().started, started)


class Case(unittest.TestCase):

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        self.clip = self.root / "deep" / "clips" / "a.pc2"
        self.path = self.clip.with_name(".a.pc2.lock")

    def hold(self, age: float = 0.0, **holder: object) -> None:
        """By somebody else."""
        self.clip.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(dict(host="node_7", process=4711, started="", task="") | holder))
        then = time.time() - age
        os.utime(self.path, (then, then))

    def there(self) -> list[str]:
        return sorted(path.name for path in self.clip.parent.iterdir())

    def test_of_many_at_once_one_has_it(self) -> None:
        for no_links in (False, True):
            got: list[Lock] = []
            start = threading.Barrier(8)

            def take() -> None:
                start.wait()
                try:
                    got.append(Lock(self.clip))
                except Held:
                    pass
            with mock.patch("os.link", side_effect=OSError) if no_links else nullcontext():
                threads = [threading.Thread(target=take) for _ in range(8)]
                for thread in threads:
                    thread.start()
                for thread in threads:
                    thread.join()
            self.assertEqual((len(got), self.there()), (1, [self.path.name]))
            got[0].release()
            self.assertFalse(self.path.exists())

    def test_it_is_held_while_its_holder_is_heard_of(self) -> None:
        for age, oldest, held in ((0.0, 600.0, True), (500.0, 600.0, True), (601.0, 600.0, False), (31.0, 30.0, False),
                                  (-3600.0, 600.0, True)):
            self.hold(age)
            if held:
                with self.assertRaisesRegex(Held, "by process 4711 on node_7, last heard of"):
                    Lock(self.clip, oldest)
                self.path.unlink()
            else:
                Lock(self.clip, oldest).release()
        self.assertFalse(self.path.exists())

    def test_of_a_holder_that_is_gone_it_is_taken_over(self) -> None:
        here = Holder.here()
        mine = dict(host=here.host, process=here.process, started=here.started)
        for holder, held in ((mine, True), ({**mine, "started": "long ago"}, False),
                             ({**mine, "process": 1 << 29}, False), (dict(task="t 1"), False), (dict(task="t 2"), True),
                             (dict(task=""), True)):
            self.hold(**holder)
            with mock.patch.dict(os.environ, RUMPLE_TASK="t 1"):
                if held:
                    self.assertRaises(Held, Lock, self.clip)
                else:
                    Lock(self.clip).release()
        self.hold()
        with mock.patch.dict(os.environ, RUMPLE_TASK=""):  # no task is no task that started again
            self.assertRaises(Held, Lock, self.clip)

    def test_a_lock_that_cannot_be_read_is_held_until_it_is_old(self) -> None:
        for text in ("", "{", "[]", '{"host": 1}'):
            self.hold()
            self.path.write_text(text)
            with self.assertRaisesRegex(Held, "by somebody"):
                Lock(self.clip)
            os.utime(self.path, (1.0, 1.0))
            Lock(self.clip).release()

    def test_who_lost_it_is_told_and_leaves_it_to_the_other(self) -> None:
        lock = Lock(self.clip)
        lock.check()
        self.hold(process=12)
        for _ in range(2):
            with self.assertRaisesRegex(Held, "was taken over by process 12 on node_7"):
                lock.check()
        lock._touched -= 100.0
        self.assertRaises(Held, lock.touch)
        lock.release()
        self.assertTrue(self.path.is_file())

    def test_a_touch_is_seen_and_not_made_too_often(self) -> None:
        lock = Lock(self.clip)
        self.addCleanup(lock.release)
        os.utime(self.path, (1.0, 1.0))
        lock.touch()
        self.assertEqual(self.path.stat().st_mtime, 1.0)
        lock._touched -= 6.0
        lock.touch()
        self.assertGreater(self.path.stat().st_mtime, 1e9)

    def test_another_ones_lock_made_meanwhile_is_put_back(self) -> None:
        """Between the look at an old lock and its removal another worker has taken it over."""
        self.hold(age=1000.0)
        rename = os.rename

        def late(source: Path, target: Path) -> None:
            if Path(source) == self.path and not late.done:  # type: ignore[attr-defined]
                late.done = True  # type: ignore[attr-defined]
                self.path.unlink()
                self.hold(process=13)
            rename(source, target)
        late.done = False  # type: ignore[attr-defined]
        with mock.patch("os.rename", late), self.assertRaisesRegex(Held, "by process 13"):
            Lock(self.clip)
        self.assertEqual(self.there(), [self.path.name])

    def test_what_came_to_nothing_leaves_no_folder(self) -> None:
        Lock(self.clip).release()
        self.assertEqual(list(self.root.iterdir()), [])
        (self.root / "deep").mkdir()  # there before
        Lock(self.clip).release()
        self.assertEqual([path.name for path in self.root.iterdir()], ["deep"])
        self.assertEqual(list((self.root / "deep").iterdir()), [])
        lock = Lock(self.clip)
        self.clip.touch()
        lock.release()
        self.assertEqual(self.there(), [self.clip.name])
        self.clip.unlink()
        for path in (self.clip.parent, self.clip.parent.parent):
            path.rmdir()

        def half(path: Path, _text: str) -> None:
            path.touch()
            raise OSError(28, "full")
        with mock.patch.object(Path, "write_text", half):
            with self.assertRaisesRegex(ClipFault, "is full"):
                Lock(self.clip)
        self.assertEqual(list(self.root.iterdir()), [])

    def test_a_folder_that_another_one_gives_up_is_made_again(self) -> None:
        mkdir = Path.mkdir

        def gone_once(path: Path, *arguments: object, **named: object) -> None:
            mkdir(path, *arguments, **named)  # type: ignore[arg-type]
            if not gone_once.done:  # type: ignore[attr-defined]
                gone_once.done = True  # type: ignore[attr-defined]
                path.rmdir()
        gone_once.done = False  # type: ignore[attr-defined]
        with mock.patch.object(Path, "mkdir", gone_once):
            Lock(self.clip).release()
        self.assertEqual(list(self.root.iterdir()), [])

    # --- a share that is away for a moment, a scanner
    @contextmanager
    def unreachable(self) -> Iterator[None]:
        opened = Path.open

        def away(path: Path, *arguments: Any, **named: Any) -> Any:
            if path == self.path:
                raise OSError(errno.EIO, "the share is away")
            return opened(path, *arguments, **named)
        with mock.patch.object(Path, "open", away):
            yield

    def touch(self, lock: Lock) -> None:
        lock._touched -= 100.0
        lock.touch()

    def test_a_lock_that_cannot_be_reached_for_a_moment_is_not_lost(self) -> None:
        lock = Lock(self.clip)
        self.addCleanup(lock.release)
        for _ in range(3 * clip_lock._MOST_MISSED):  # not in a row
            with self.unreachable():
                self.touch(lock)
            self.touch(lock)
        lock.check()

    def test_one_that_cannot_be_reached_for_long_is_said_and_is_no_other_ones(self) -> None:
        lock = Lock(self.clip)
        self.addCleanup(lock.release)
        with self.unreachable(), self.assertRaisesRegex(ClipFault, "is gone or cannot be made: connect") as caught:
            for _ in range(100):
                self.touch(lock)
        self.assertNotIsInstance(caught.exception, Held)
        with self.unreachable(), self.assertRaises(ClipFault) as caught:
            lock.check()
        self.assertNotIsInstance(caught.exception, Held)

    def test_nor_is_one_whose_folder_is_away(self) -> None:
        """As Windows says it of a share; a lock that is gone from its folder was taken over."""
        lock = Lock(self.clip)
        away = self.clip.parent.rename(self.root / "away")
        self.touch(lock)
        with self.assertRaises(ClipFault) as caught:
            lock.check()
        self.assertNotIsInstance(caught.exception, Held)
        away.rename(self.clip.parent)
        lock.check()
        self.path.unlink()
        self.assertRaisesRegex(Held, "taken over by somebody", lock.check)

    def test_a_touch_is_by_the_clock_of_the_disk(self) -> None:
        """os.utime() sends the worker's on Windows."""
        lock, utime = Lock(self.clip), os.utime
        self.addCleanup(lock.release)

        def slow(path: Path) -> None:
            utime(path, (time.time() - 700.0,) * 2)
        with mock.patch("os.utime", slow):
            self.touch(lock)
        with mock.patch.object(Holder, "is_gone", return_value=False), self.assertRaises(Held):
            Lock(self.clip)
        lock.check()

    def test_a_touch_is_never_written_into_the_lock_of_another_one(self) -> None:
        """That takes it over between the look at it and the touch."""
        lock, seek = Lock(self.clip), Holder.of

        def late(text: bytes) -> Holder | None:
            self.path.rename(self.path.with_name("aside"))
            self.hold(process=13)
            return seek(text)
        with mock.patch.object(Holder, "of", late):
            self.touch(lock)
        self.assertEqual(json.loads(self.path.read_text())["process"], 13)

    def test_temporary_files_that_cannot_be_removed_harm_nothing(self) -> None:
        """A virus scanner has them open."""
        unlink = Path.unlink

        def scanned(path: Path, missing_ok: bool = False) -> None:
            if path.suffix == ".part":
                raise PermissionError(13, "in use")
            unlink(path, missing_ok)
        with mock.patch.object(Path, "unlink", scanned):
            for age in (None, 1000.0):
                if age is not None:
                    self.hold(age)
                lock = Lock(self.clip)
                lock.check()
                lock.release()
                self.assertFalse(self.path.exists())
            self.assertTrue(clip_folder.can_write(self.clip.parent))

    def test_a_release_that_is_refused_for_a_moment_is_done(self) -> None:
        lock, unlink, answers = Lock(self.clip), Path.unlink, [PermissionError(13, "in use")]

        def scanned(path: Path, missing_ok: bool = False) -> None:
            if answers:
                raise answers.pop()
            unlink(path, missing_ok)
        with mock.patch.object(Path, "unlink", scanned), mock.patch("time.sleep"), \
                mock.patch("rumple.native.platforms.ON_WINDOWS", True):
            lock.release()
        self.assertFalse(self.path.exists())
