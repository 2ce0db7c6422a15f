# SPDX-License-Identifier: GPL-3.0-or-later
"""What lives from one frame to the next as a file: a bake that was ended goes on behind that frame. No bpy here.

The library checks a state as a whole when it is made of the arrays again; the archive has a checksum of each array.
"""
from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..native import kernels
from .cloth import ClothFrame, SwingInput
from .engine import Wrinkles
from .frame_cache import CachedFrame
from .on_cloth import OnCloth, State

_BASE = ("positions", "gap", "body_hint")  # of a ClothFrame
_SWING = ("seconds", "world_from_object", "location")  # of a SwingInput
Arrays = dict[str, Any]


class CannotGoOn(ValueError):
    """A checkpoint that is damaged, or of something else."""


@dataclass(frozen=True)
class Checkpoint:
    """One frame of a bake."""

    sample: int
    arrays: Arrays

    @classmethod
    def of(cls, sample: int, cached: CachedFrame) -> "Checkpoint":
        """Of a frame that was solved."""
        about = {"inputs": _bytes(cached.input_digest), "chosen": _bytes(cached.settings_digest),
                 "final": np.uint8(cached.final), "chain": _bytes(cached.chain)}
        return cls(sample, {**about, **_state_arrays(cached.state)})

    @property
    def input_digest(self) -> bytes:
        """What the frame was solved for."""
        return self._array("inputs").tobytes()

    def restored(self, evaluator: Wrinkles) -> CachedFrame:
        """To go on from. Raises CannotGoOn."""
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
        """None where there is none that is whole and of this bake."""
        try:
            with np.load(path, allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in stored.files}
            if arrays.pop("bake").tobytes() != identity.encode():
                return None
            return cls(int(arrays.pop("sample")), arrays)
        except Exception:  # zipfile, zlib and NumPy have a dozen of their own for damaged files
            return None


def _bytes(data: bytes) -> np.ndarray:
    return np.frombuffer(data, np.uint8)


def carry_frames(former: Wrinkles, to: Wrinkles) -> None:
    """Go on with the stored frames of wrinkles that are solved to the same bits, and shown otherwise."""
    def restored(cached: CachedFrame) -> CachedFrame:
        state = _state_of(to, _state_arrays(cached.state))
        return CachedFrame.of(state, cached.input_digest, cached.settings_digest, cached.final, cached.report,
                              cached.chain)

    to.frame_cache.limit_bytes = former.frame_cache.limit_bytes
    to.frame_cache.take(former.frame_cache, restored)
    to.follow_inputs_of(former)


# ---------------------------------------------------------------- states
def _named(prefix: str, arrays: Arrays) -> Arrays:
    """As arrays. NumPy 1 takes a whole number for one of 32 bits on Windows: the file is to be the same everywhere."""
    return {f"{prefix}/{name}": np.asarray(values, np.int64 if type(values) is int else None)
            for name, values in arrays.items()}


def _below(prefix: str, arrays: Arrays) -> Arrays:
    """What _named() named so."""
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
    return out


_STATES: dict[type, Any] = {
    kernels.WrinkleMeshModel: kernels.WrinkleMeshState, kernels.WrinkleMeshLayers: kernels.WrinkleLayersState,
    kernels.WrinkleFieldModel: kernels.WrinkleFieldState, kernels.WrinklePathsModel: kernels.WrinklePathsState}


def _state_of(evaluator: Wrinkles, arrays: Arrays) -> Any:
    own = _STATES[type(evaluator.model)].of(evaluator.model, _below("wrinkles", arrays))
    kept = _below("cloth", arrays)
    return OnCloth(_cloth_of(evaluator, kept, arrays), own) if kept else own


def _check(arrays: Arrays, expected: tuple[tuple[str, tuple[int, ...], type], ...]) -> None:
    """Arrays that no function of the library checks. Raises CannotGoOn."""
    for name, shape, dtype in expected:
        if arrays[name].shape != shape or arrays[name].dtype != dtype:
            raise CannotGoOn(f"{name}: expected an array {shape} of {np.dtype(dtype)}")
        if not np.isfinite(arrays[name]).all():
            raise CannotGoOn(f"{name}: expected finite numbers")


def _cloth_of(evaluator: Wrinkles, kept: Arrays, arrays: Arrays) -> ClothFrame:
    stage, base = evaluator.base_cloth(), _below("base", arrays)
    swing, drape = _below("swing", arrays), _below("drape", arrays)
    count = evaluator.solved_surface.vertex_count
    hints = (count,) if base["body_hint"].size else (0,)
    _check(base, (("positions", (count, 3), np.float32), ("gap", (count,), np.float32),
                  ("body_hint", hints, np.int32)))
    if swing:
        _check(swing, (("seconds", (), np.float64), ("world_from_object", (3, 3), np.float64),
                       ("location", (3,), np.float64)))
    return ClothFrame(
        **base, state=kernels.BaseClothState.of(stage.cloth.model, kept), report=None,
        swing_input=SwingInput(float(swing["seconds"]), swing["world_from_object"], swing["location"]) if swing
        else None,
        drape=kernels.WrinkleLayersState.of(stage.drape.model, drape) if drape else None)
