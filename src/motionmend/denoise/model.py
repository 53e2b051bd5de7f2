"""The denoiser: settings, learning, and the fitted model that repairs."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ..arrays import Floats
from ..bodies.motion import Markers, Motion, Recording, Repaired
from ..errors import MismatchError, UsageError, few
from ..numerics.robust import ESTIMATORS
from ..numerics.ssa import Eigenbases, eigenbases, lag_covariance
from .adaptive.recording import Knowledge, mend_alone, mend_recording
from .bases.repair import repair_channels
from .channels.bare_names import bare
from .channels.cloud import Anchors
from .channels.layout import Layout, learn_layout, own_layout
from .channels.recording import to_channels
from .channels.rotation_order import Reordered, reordered
from .dynamics.kalman import Dynamics, fit_dynamics, smooth_with
from .faults.flipped import but_for_flips
from .faults.lost_capture import but_for_lost_capture
from .faults.rest_first import but_for_rest_pose
from .faults.slower import but_for_repeats
from .gaps.likeliest import process_of
from .library.exemplars import Library
from .library.markers import MarkerLibrary
from .library.other_order import by_what_is_meant, rewritten
from .library.passages import rejoined
from .library.statistics import Statistics, statistics
from .outcome import classic_outcome, opened_where_unsure, pca_outcome, repaired_recording
from .rivals.classic import FILTERS, GAP_FILLERS
from .rivals.filtered import channelwise
from .several_people import by_people

MODEL_METHODS = ("adaptive", "paper", "kalman-data")
CLASSIC_METHODS = (*FILTERS, *GAP_FILLERS, "pca")
METHODS = (*MODEL_METHODS, *CLASSIC_METHODS)
MODEL_FREE_METHODS = ("adaptive", *CLASSIC_METHODS)
SHORTEST_BENT = 3  # frames of a window that shows how clean motion bends


@dataclass(frozen=True)
class Denoiser:
    """How to learn a denoiser.

    Attributes
    ----------
    window : M, frames of a lag window at `fps`.
    fps : rate the model is learned at, Hz.
    energy : share of the variance the bases keep, in (0, 1].
    """

    window: int = 20
    fps: float = 30.0
    energy: float = 0.99

    def __post_init__(self) -> None:
        if self.window < 2:
            raise UsageError(f"a window needs at least 2 frames, came {self.window}")
        if not self.fps > 0:
            raise UsageError(f"the model's rate must be above 0 Hz, came {self.fps}")
        if not 0 < self.energy <= 1:
            raise UsageError(f"the energy kept is a share in (0, 1], came {self.energy}")

    def fit(self, clips: Iterable[Motion | Markers]) -> "DenoiserModel":
        """Learn filter bases and dynamics from clean clips.

        Parameters
        ----------
        clips : motions of one skeleton's channels, or markers of one marker set; any rates. They are gone through
            twice. What can be iterated over more than once, such as an object that reads its files anew each time,
            is never held in memory as a whole; an iterator that runs out is.

        Raises
        ------
        MismatchError : no clip, clips that do not go together, or none as long as a window.

        Source
        ------
        Section 2.2.1.
        """
        again = list(clips) if isinstance(clips, Iterator) else clips
        with threadpool_limits(1, user_api="blas"):  # many small products: threads would wait for each other
            layout = learn_layout(again)
            return self.learned(layout, statistics(again, layout, self.window, self.fps))

    def learned(self, layout: Layout, clips: Statistics, notes: tuple[str, ...] = ()) -> "DenoiserModel":
        """The model that statistics of clips make.

        Parameters
        ----------
        layout : the clips' channels.
        clips : their statistics at this window and rate.
        notes : what was done to the clips before.

        Raises
        ------
        MismatchError : no clip is as long as a window, or none moves.
        """
        bases = eigenbases(clips.lag, self.energy)
        return DenoiserModel(
            settings=self,
            layout=layout,
            bases=bases,
            dynamics=fit_dynamics(rejoined(clips.passages), self.fps),
            library=clips.library(),
            postures=clips.postures,
            clips=clips.clips,
            frames=clips.frames,
            notes=(*clips.notes(), *notes),
        )


@dataclass(frozen=True, eq=False)
class DenoiserModel:
    """A fitted denoiser.

    Attributes
    ----------
    settings : it was learned with.
    layout : its channels.
    bases : spatio-temporal filter bases at `settings.fps`.
    dynamics : learned linear dynamics, for the method kalman-data.
    library : how sharply clean motion bends at each rate, and windows of the clips as they were.
    postures : examples of the marker set, for gaps; None for motions.
    clips, frames : how many it was learned from.
    notes : what was left out or bridged in the clips.
    """

    settings: Denoiser
    layout: Layout
    bases: Eigenbases
    dynamics: Dynamics
    library: Library
    postures: MarkerLibrary | None
    clips: int
    frames: int
    notes: tuple[str, ...] = ()

    def repair(
        self,
        recording: Recording,
        method: str = "adaptive",
        *,
        robust: str = "welsch",
        footskate: bool = False,
        max_std: float | None = None,
        whole: bool = True,
    ) -> Repaired[Recording]:
        """Repair a recording: remove noise and outliers, fill what is missing.

        Parameters
        ----------
        recording : of the model's channels, at any rate, place and heading.
        method : one of `METHODS`.
        robust : the estimator of method paper: welsch, tukey, huber, student or square (figure 2.3).
        footskate : clean foot skate afterwards (motions only).
        max_std : a gap less sure than this stays open: rad for motions, m for markers; None fills what it can.
        whole : False where the recording goes on before and after its frames, as while it is still being made.

        Returns
        -------
        The same channels, frames and rate.

        Raises
        ------
        MismatchError : the recording is of another kind or channel set.
        UsageError : unknown method or estimator, or foot-skate cleaning of markers.

        Source
        ------
        Section 2.2.2-2.2.5; the rivals of section 2.3.2.
        """
        if method not in METHODS:
            raise UsageError(f"unknown method {method!r}: choose one of {', '.join(METHODS)}")
        if robust not in ESTIMATORS:
            raise UsageError(f"unknown robust estimator {robust!r}: choose one of {', '.join(ESTIMATORS)}")
        if footskate and isinstance(recording, Markers):
            raise UsageError("foot-skate cleaning moves joints: it needs a skeleton motion, came markers")
        if method in CLASSIC_METHODS:
            outcome = repair_without_model(recording, method)
        else:
            with threadpool_limits(1, user_api="blas"):
                taught = partial(self._taught, method=method, robust=robust, whole=whole)
                outcome = by_people(taught, recording, self.layout.names, labels=method == "adaptive")
        if max_std is not None:
            outcome = opened_where_unsure(outcome, max_std)
        return _without_footskate(outcome) if footskate else outcome

    def _taught(self, recording: Recording, method: str, robust: str, whole: bool) -> Repaired[Recording]:
        model, said = self._with_joints_as_in(recording)
        by_example = partial(model._by_example, method=method, robust=robust, whole=whole)
        meant = partial(by_what_is_meant, by_example, layout=model.layout, library=model.library)
        taught = partial(but_for_rest_pose, meant)
        if method == "adaptive":
            outcome = but_for_repeats(partial(but_for_lost_capture, partial(but_for_flips, taught)), recording)
        else:
            outcome = taught(recording)
        return _warned(outcome, said)

    def _with_joints_as_in(self, recording: Motion | Markers) -> tuple["DenoiserModel", tuple[str, ...]]:
        """The model with its clips' joints turning in the recording's order, where that can be written, and what is to
        be said of it."""
        if not isinstance(recording, Motion):
            return self, ()
        turned = reordered(recording.skeleton, self.layout.names)
        if not turned or self.settings.window < SHORTEST_BENT:
            return self, ()
        said = (
            f"{few([joint.joint for joint in turned])} turn in another order than in the library's clips: these were "
            "written in the recording's order"
        )
        try:
            return _with_joints_in_order(self, turned), (said,)
        except MismatchError:  # so few windows teach nothing anew
            return self, ()

    def _by_example(self, recording: Recording, method: str, robust: str, whole: bool) -> Repaired[Recording]:
        fps = self.settings.fps
        if method == "adaptive":
            known = Knowledge(
                self.layout, self.library, self.bases, self.postures, fps, process_of(self.dynamics), whole
            )
            return mend_recording(recording, known)
        channels = to_channels(recording, self.layout)
        if method == "paper":
            found = repair_channels(channels.values, self.bases, fps, recording.fps, robust)
            return repaired_recording(recording, self.layout, channels, found, method)
        stride = max(1, round(recording.fps / fps))
        filtered = smooth_with(self.dynamics, channels.values, recording.fps, stride)
        return classic_outcome(recording, self.layout, channels, filtered, method)

    def to_arrays(self) -> tuple[dict[str, Floats], dict[str, Any]]:
        """Arrays and a JSON-able header from which `from_arrays` makes the model again."""
        arrays: dict[str, Any] = {
            "bases.mean": self.bases.mean,
            "bases.vectors": self.bases.vectors,
            "bases.values": self.bases.values,
            "bases.discarded": self.bases.discarded,
            "layout.centre": self.layout.centre,
            "layout.up": self.layout.up,
        }
        if self.layout.anchors is not None:
            arrays["anchors.indices"] = self.layout.anchors.indices
            arrays["anchors.template"] = self.layout.anchors.template
        arrays |= {f"dynamics.{name}": value for name, value in self.dynamics.to_arrays().items()}
        arrays |= {f"library.{name}": value for name, value in self.library.to_arrays().items()}
        if self.postures is not None:
            arrays |= {f"postures.{name}": value for name, value in self.postures.to_arrays().items()}
        header = {
            "window": self.settings.window,
            "fps": self.settings.fps,
            "energy": self.settings.energy,
            "kind": self.layout.kind,
            "names": list(self.layout.names),
            "total": self.bases.total,
            "clips": self.clips,
            "frames": self.frames,
            "notes": list(self.notes),
        }
        return arrays, header

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any], header: Mapping[str, Any]) -> "DenoiserModel":
        """The model that `to_arrays` took apart."""
        names = tuple(header["names"]) if header["kind"] == "markers" else bare(header["names"])
        anchors = None
        if "anchors.indices" in arrays:
            anchors = Anchors(arrays["anchors.indices"], arrays["anchors.template"])

        def below(prefix: str) -> dict[str, Any]:
            return {name[len(prefix) :]: value for name, value in arrays.items() if name.startswith(prefix)}

        return cls(
            settings=Denoiser(header["window"], header["fps"], header["energy"]),
            layout=Layout(header["kind"], names, arrays["layout.centre"], anchors, arrays["layout.up"]),
            bases=Eigenbases(
                arrays["bases.mean"],
                arrays["bases.vectors"],
                arrays["bases.values"],
                header["total"],
                arrays["bases.discarded"],
            ),
            dynamics=Dynamics.from_arrays(below("dynamics.")),
            library=Library.from_arrays(below("library.")),
            postures=MarkerLibrary.from_arrays(below("postures.")) if "postures.windows" in arrays else None,
            clips=header["clips"],
            frames=header["frames"],
            notes=tuple(header["notes"]),
        )


@lru_cache(maxsize=1)  # files of a folder turn alike, and so do the windows of a stream
def _with_joints_in_order(model: DenoiserModel, joints: tuple[Reordered, ...]) -> DenoiserModel:
    """The model of the same clips with these joints turning in a recording's order, as its exemplars show them."""
    layout, library = rewritten(model.layout, model.library, joints)
    windows = [np.array(window, dtype=np.float64) for window in library.exemplars]
    return replace(
        model,
        layout=layout,
        bases=eigenbases(lag_covariance(windows, model.settings.window), model.settings.energy),
        dynamics=fit_dynamics(windows, model.settings.fps, apart=True),
        library=library,
    )


def repair_without_model(recording: Recording, method: str = "adaptive") -> Repaired[Recording]:
    """Repair without a model: by the filters and gap fillers people use today, or adaptively by what it shows itself.

    Parameters
    ----------
    recording : motion or markers.
    method : one of `MODEL_FREE_METHODS`.

    Raises
    ------
    UsageError : another method, or pca on joint angles.
    """
    if method not in MODEL_FREE_METHODS:
        raise UsageError(f"method {method!r} needs a model: give one, or choose {', '.join(MODEL_FREE_METHODS)}")
    by_itself = partial(but_for_rest_pose, partial(_by_itself, method=method))
    if method != "adaptive":
        return by_itself(recording)
    return but_for_repeats(partial(but_for_lost_capture, partial(but_for_flips, by_itself)), recording)


def _by_itself(recording: Recording, method: str) -> Repaired[Recording]:
    if method == "adaptive":
        with threadpool_limits(1, user_api="blas"):
            return mend_alone(recording)
    if method == "pca":
        if not isinstance(recording, Markers):
            raise UsageError("method pca fills markers, came joint angles: choose linear or spline")
        return pca_outcome(recording)
    layout = own_layout(recording)
    channels = to_channels(recording, layout)
    filtered = channelwise({**FILTERS, **GAP_FILLERS}[method], channels.values, recording.fps)
    return classic_outcome(recording, layout, channels, filtered, method)


def _warned(outcome: Repaired[Recording], said: tuple[str, ...]) -> Repaired[Recording]:
    return replace(outcome, warnings=(*said, *outcome.warnings))


def _without_footskate(outcome: Repaired[Recording]) -> Repaired[Recording]:
    from .footskate.clean_up import clean_footskate

    assert isinstance(outcome.recording, Motion)
    cleaned = clean_footskate(outcome.recording)
    said = (
        f"foot-skate clean-up: {cleaned.skate_before * 100:.1f} cm/s in contact before, "
        f"{cleaned.skate_after * 100:.1f} after"
    )
    return replace(outcome, recording=cleaned.motion, warnings=(*outcome.warnings, said))
