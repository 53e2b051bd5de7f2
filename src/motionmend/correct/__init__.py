"""The correcting room: pairs of a sensor's postures and the truth teach it; live and recorded ones come out right."""

from ..rooms import opened_late

_HOME = {
    "METHODS": "corrector",
    "Corrected": "corrector",
    "Corrector": "corrector",
    "CorrectorModel": "corrector",
    "CorrectorState": "corrector",
    "Pair": "pairing",
    "match": "pairs",
    "strange": "pairs",
}

__all__ = list(_HOME)

__getattr__ = opened_late(__name__, _HOME)
