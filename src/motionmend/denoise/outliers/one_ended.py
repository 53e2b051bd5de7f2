"""Rejected samples with which a recording begins or ends: what leaps once, and not back, is right on either side.

An angle that is off for a while leaps away and back. Where it leaps once, a smoother that knows how calmly it moves
takes all before the leap, or all after it, for outliers, however long: a few frames of a rest pose, a solver that found
another pose for the limb, a limb that was not driven yet. Nothing tells which side is wrong; both are left as measured,
unless the recording is so full of stretches that do come back that one of them may lie at an end by chance.
"""

from collections import defaultdict

import numpy as np
from scipy.special import bdtrc

from ...arrays import Bools, Floats, Ints, runs

FEWEST = 2  # frames on end; a lone sample is an outlier
STEADY = 0.2  # of how far a stretch leaps, by which it differs from frame to frame; outliers lie anywhere
OFTEN = 0.003  # such leaps at an end, before anything is known
SCATTER = 2.0  # deviations of how often something happens by chance
EDGE = 3  # frames beside the leap, that may bend as they will
HALF_TURN = 180.0  # degrees; 0 and half turns, to the last digit, are written where nothing is known
MOSTLY = 0.5  # of its samples


def begins_or_ends(measured: Floats, outlier: Bools, whole: tuple[bool, bool] = (True, True)) -> tuple[Bools, Bools]:
    """Rejected samples that are on one side of a leap, and the recording has no other side.

    Parameters
    ----------
    measured : (T, C) degrees and centimetres, NaN = missing.
    outlier : (T, C) rejected.
    whole : whether the recording begins, and ends, with these frames; what goes on beyond them may still come back.

    Returns
    -------
    kept : (T, C) True where a rejected sample is no outlier.
    leap : (T, C) True for those of them beside the leap.
    """
    kept, leap = np.zeros(outlier.shape, dtype=np.bool_), np.zeros(outlier.shape, dtype=np.bool_)
    frames, channels = outlier.shape
    ends = _steady_runs(measured, outlier, whole, at_ends=True)
    if not ends:
        return kept, leap
    within = _steady_runs(measured, outlier, whole, at_ends=False)
    lengths, widths = _sizes(within)
    leap_lengths, leap_widths = _sizes(ends)
    rejected_at_ends = int((leap_lengths * leap_widths).sum())
    share = (int(outlier.sum()) - rejected_at_ends) / max(1, int(np.isfinite(measured).sum()) - rejected_at_ends)
    for (first, last), whose in ends.items():
        length, width = last + 1 - first, len(whose)
        by_chance = 2.0 * float(lengths[(lengths >= length) & (widths >= width)].sum()) / frames
        lone = share**length * STEADY ** (length - 1)  # outliers of one frame each, on end and off alike
        by_chance += 2.0 * float(bdtrc(width - 1, channels, lone))
        others = float(((leap_lengths >= length) & (leap_widths >= width)).sum()) - 1.0
        beyond = others - by_chance - SCATTER * np.sqrt(by_chance)
        if OFTEN + max(0.0, beyond) > by_chance:
            here = np.zeros(outlier.shape, dtype=np.bool_)
            here[first : last + 1, whose] = outlier[first : last + 1, whose]
            kept |= here
            at_start = not np.isfinite(measured[:first, whose]).any()
            beside = slice(max(first, last + 1 - EDGE), None) if at_start else slice(0, first + EDGE)
            leap[beside] |= here[beside]
    return kept, leap


def _steady_runs(
    measured: Floats, outlier: Bools, whole: tuple[bool, bool], *, at_ends: bool
) -> dict[tuple[int, int], list[int]]:
    """First and last frame of rejected runs that leap by more than they change, and the channels in which they do.

    Those at the recording's ends, or those within it. Channels that leap in the same frames are one leap.
    """
    found: dict[tuple[int, int], list[int]] = defaultdict(list)
    for channel in np.flatnonzero(outlier.any(axis=0)).tolist():
        seen = np.flatnonzero(np.isfinite(measured[:, channel]))
        shown, rejected = measured[seen, channel], outlier[seen, channel]
        for start, stop in runs(rejected):
            inside = start > 0 and stop < len(seen)
            if inside == at_ends or stop - start < FEWEST or stop - start == len(seen):
                continue
            if not inside and not whole[1 if start else 0]:
                continue
            if not _steady(shown, start, stop):
                continue
            if inside or np.mean(shown[start:stop] % HALF_TURN == 0.0) < MOSTLY:
                found[int(seen[start]), int(seen[stop - 1])].append(channel)
    return found


def _sizes(stretches: dict[tuple[int, int], list[int]]) -> tuple[Ints, Ints]:
    """(N,) how many frames each stretch lasts, and how many channels are off in it."""
    lengths = np.array([last + 1 - first for first, last in stretches], dtype=np.int64)
    return lengths, np.array([len(whose) for whose in stretches.values()], dtype=np.int64)


def _steady(shown: Floats, start: int, stop: int) -> bool:
    """True where samples (N,) from one to before another change less than they leap there."""
    run = shown[start:stop]
    leaps = [abs(float(np.median(run[:EDGE]) - np.median(shown[max(0, start - EDGE) : start])))] if start else []
    if stop < len(shown):
        leaps.append(abs(float(np.median(run[-EDGE:]) - np.median(shown[stop : stop + EDGE]))))
    return bool(np.median(np.abs(np.diff(run))) < STEADY * min(leaps))
