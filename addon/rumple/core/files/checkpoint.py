# SPDX-License-Identifier: GPL-3.0-or-later
"""Checkpoints: the solver's state after one frame as a file, from which an interrupted bake resumes. No bpy here.

The archive has a checksum of each array. The library checks the whole state when it is restored from the arrays.
"""
from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ...native import kernels
from ..cloth.base_cloth import ClothFrame, SwingInput
from ..cloth.draped_cloth import DrapedCloth
from ..cloth.on_cloth import OnCloth, State
from ..frame.engine import Wrinkles
from ..frame.frame_cache import CachedFrame

_BASE = ("positions", "gap", "body_hint")  # of a ClothFrame
_SWING = ("seconds", "world_from_object", "location")  # of a SwingInput
Arrays = dict[str, Any]


class CannotGoOn(ValueError):
    """A checkpoint that is damaged, or belongs to something else."""


@dataclass(frozen=True)
class Checkpoint:
    """The state after one frame of a bake."""

    sample: int
    arrays: Arrays

    @classmethod
    def of(cls, sample: int, cached: CachedFrame) -> "Checkpoint":
        """The checkpoint of a solved frame."""
        about = {"inputs": _bytes(cached.input_digest), "chosen": _bytes(cached.settings_digest),
                 "final": np.uint8(cached.final), "chain": _bytes(cached.chain)}
        return cls(sample, {**about, **_state_arrays(cached.state)})

    @property
    def input_digest(self) -> bytes:
        """Digest of the inputs that the frame was solved for."""
        return self._array("inputs").tobytes()

    def restored(self, evaluator: Wrinkles) -> CachedFrame:
        """The frame to continue from. Raises CannotGoOn."""
        try:
            state = _state_of(evaluator, self.arrays)
            return CachedFrame.of(state, self.input_digest, self._array("chosen").tobytes(),
                                  bool(self._array("final")), None, self._array("chain").tobytes())
        except (ValueError, TypeError, KeyError) as error:
            raise CannotGoOn(str(error)) from error

    def _array(self, name: str) -> np.ndarray:
        if name not in self.arrays:
            raise CannotGoOn(f"there is no array {name}")
        return self.arrays[name]

    # --- the file
    def to_bytes(self, identity: str) -> bytes:
        """identity: of the bake."""
        out = io.BytesIO()
        about = {"bake": _bytes(identity.encode()), "sample": np.int64(self.sample)}
        np.savez(out, **about, **self.arrays)  # type: ignore[arg-type]
        return out.getvalue()

    @classmethod
    def read(cls, path: Path | BinaryIO, identity: str) -> "Checkpoint | None":
        """None if the file is missing, damaged or of another bake."""
        try:
            with np.load(path, allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in stored.files}
            if arrays.pop("bake").tobytes() != identity.encode():
                return None
            return cls(int(arrays.pop("sample")), arrays)
        except Exception:  # zipfile, zlib and NumPy raise many different exceptions for damaged files
            return None


def _bytes(data: bytes) -> np.ndarray:
    return np.frombuffer(data, np.uint8)


def carry_frames(former: Wrinkles, to: Wrinkles) -> None:
    """Take over the stored frames of other wrinkles, which are solved to the same bits but displayed differently."""
    def restored(cached: CachedFrame) -> CachedFrame:
        state = _state_of(to, _state_arrays(cached.state))
        return CachedFrame.of(state, cached.input_digest, cached.settings_digest, cached.final, cached.report,
                              cached.chain)

    to.frame_cache.limit_bytes = former.frame_cache.limit_bytes
    to.frame_cache.take(former.frame_cache, restored)
    to.follow_inputs_of(former)


# ---------------------------------------------------------------- states
def _named(prefix: str, arrays: Arrays) -> Arrays:
    """The values as arrays, with a prefix before their names. Python's integers become int64: NumPy 1 would make them
    32 bits on Windows, and the file must be the same on every system."""
    return {f"{prefix}/{name}": np.asarray(values, np.int64 if type(values) is int else None)
            for name, values in arrays.items()}


def _below(prefix: str, arrays: Arrays) -> Arrays:
    """The arrays with this prefix, without it: the inverse of _named()."""
    return {name[len(prefix) + 1:]: values for name, values in arrays.items() if name.startswith(f"{prefix}/")}


def _state_arrays(state: State) -> Arrays:
    if not isinstance(state, OnCloth):
        return _named("wrinkles", state.arrays)
    cloth = state.cloth
    out = {**_named("wrinkles", state.wrinkles.arrays), **_named("cloth", cloth.state.arrays),
           **_named("base", {name: getattr(cloth, name) for name in _BASE})}
    if cloth.swing_input is not None:
        out.update(_named("swing", {name: getattr(cloth.swing_input, name) for name in _SWING}))
    if cloth.drape is not None:
        out.update(_named("drape", cloth.drape.arrays))
    if cloth.solved is not None:
        out.update(_named("coarse", {"solved": cloth.solved}))
    return out


_STATES: dict[type, Any] = {
    kernels.WrinkleMeshModel: kernels.WrinkleMeshState, kernels.WrinkleMeshLayers: kernels.WrinkleLayersState,
    kernels.WrinkleFieldModel: kernels.WrinkleFieldState, kernels.WrinklePathsModel: kernels.WrinklePathsState}


def _state_of(evaluator: Wrinkles, arrays: Arrays) -> Any:
    own = _STATES[type(evaluator.model)].of(evaluator.model, _below("wrinkles", arrays))
    kept = _below("cloth", arrays)
    return OnCloth(_cloth_of(evaluator, kept, arrays), own) if kept else own


def _check(arrays: Arrays, expected: tuple[tuple[str, tuple[int, ...], type], ...]) -> None:
    """Check arrays that no function of the library checks. Raises CannotGoOn."""
    for name, shape, dtype in expected:
        if arrays[name].shape != shape or arrays[name].dtype != dtype:
            raise CannotGoOn(f"{name}: expected an array {shape} of {np.dtype(dtype)}")
        if not np.isfinite(arrays[name]).all():
            raise CannotGoOn(f"{name}: expected finite numbers")


def _cloth_of(evaluator: Wrinkles, kept: Arrays, arrays: Arrays) -> ClothFrame:
    base, coarse = _below("base", arrays), _below("coarse", arrays)
    swing, drape = _below("swing", arrays), _below("drape", arrays)
    draped = _draped_cloth(evaluator, coarse)
    count = evaluator.solved_surface.vertex_count
    hints = (count,) if base["body_hint"].size else (0,)
    _check(base, (("positions", (count, 3), np.float32), ("gap", (count,), np.float32),
                  ("body_hint", hints, np.int32)))
    if swing:
        _check(swing, (("seconds", (), np.float64), ("world_from_object", (3, 3), np.float64),
                       ("location", (3,), np.float64)))
    return ClothFrame(
        **base, state=kernels.BaseClothState.of(draped.cloth.model, kept), report=None,
        swing_input=SwingInput(float(swing["seconds"]), swing["world_from_object"], swing["location"]) if swing
        else None,
        drape=kernels.WrinkleLayersState.of(draped.drape.model, drape) if drape else None, **coarse)


def _draped_cloth(evaluator: Wrinkles, coarse: Arrays) -> DrapedCloth:
    """What solved a base cloth. coarse: arrays of one that was solved on the coarse mesh of a dense or thick garment,
    else none. Raises CannotGoOn if they do not match it."""
    if not coarse:
        return evaluator.draped_cloth()
    mesh = evaluator.cloth_mesh
    if mesh is None:
        raise CannotGoOn("its base cloth was solved on a coarse mesh")
    _check(coarse, (("solved", (mesh.coarse.surface.vertex_count, 3), np.float32),))
    return evaluator.draped_cloth(coarse=True)
