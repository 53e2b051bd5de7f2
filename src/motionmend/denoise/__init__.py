"""The denoising room: clean clips teach it, spoiled recordings come out repaired (section 2 of the dissertation)."""

from ..rooms import opened_late

_HOME = {
    "CLASSIC_METHODS": "model",
    "MODEL_FREE_METHODS": "model",
    "METHODS": "model",
    "Denoiser": "model",
    "DenoiserModel": "model",
    "repair_without_model": "model",
    "FixedLag": "fixed_lag",
    "repair_with_lag": "fixed_lag",
    "unspoiled": "spoiled_clips",
}

__all__ = list(_HOME)

__getattr__ = opened_late(__name__, _HOME)
