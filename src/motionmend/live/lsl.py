"""Corrected skeletons to laboratories: Lab Streaming Layer outlets of type MoCap, one for each client."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final, final

import numpy as np

from ..errors import FileError
from .messages import Answer, Frame, Hello

TYPE: Final = "MoCap"
ENDING: Final = 8  # streams at a time
_OF_JOINT: Final = (("x", "PositionX", "meters"), ("y", "PositionY", "meters"), ("z", "PositionZ", "meters"))


@final
class Laboratory:
    """A listener of the server that offers each client's corrected frames as a stream.

    The first client's stream has the name given, the second's the name with `-2` behind it, and so on; a client that
    begins anew with the same joints keeps its stream. Channels are x, y, z of every joint in m, then every joint's
    reliability; their labels stand in the description, as XDF's meta-data of motion capture has them.

    Parameters
    ----------
    name : of the streams.

    Raises
    ------
    FileError : liblsl cannot be loaded.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._lsl = _library()
        self._outlets: dict[int, tuple[Hello, Any]] = {}
        self._ending = ThreadPoolExecutor(ENDING, "lsl")

    def opened(self, client: int, hello: Hello) -> None:
        """A client has begun, or begun anew."""
        if client in self._outlets and self._outlets[client][0] == hello:
            return
        self.closed(client)
        taken = {outlet.get_info().name() for _, outlet in self._outlets.values()}
        names = (self._name if k == 1 else f"{self._name}-{k}" for k in range(1, len(taken) + 2))
        name = next(one for one in names if one not in taken)
        self._outlets[client] = (hello, self._lsl.StreamOutlet(self._described(name, hello)))

    def wants(self, client: int) -> bool:
        """Whether the client has a stream."""
        return client in self._outlets

    def frame(self, client: int, frame: Frame, answer: Answer) -> None:
        """Push a frame, stamped with the time at which it came from its sensor."""
        outlet = self._outlets[client][1]
        sample = np.concatenate([answer.joints.reshape(-1), answer.reliability]).astype(np.float32)
        outlet.push_sample(sample.tolist(), self._lsl.local_clock() - (answer.t_out - answer.t_in))

    def closed(self, client: int) -> None:
        """A client has left: its stream ends.

        LSL takes 25 ms to end one, in which no other client shall wait: elsewhere, where the last to know it lets go.
        """
        if client in self._outlets:
            last = [self._outlets.pop(client)]
            self._ending.submit(last.clear)

    def _described(self, name: str, hello: Hello) -> Any:
        """A stream's description: what each channel is."""
        info = self._lsl.StreamInfo(
            name,
            TYPE,
            4 * len(hello.names),
            hello.fps,
            self._lsl.cf_float32,
            f"motionmend-{name}-{hello.skeleton}",
        )
        description = info.desc()
        description.append_child_value("manufacturer", "motionmend")
        description.append_child_value("skeleton", hello.skeleton)
        channels = description.append_child("channels")
        for joint in hello.names:
            for axis, kind, unit in _OF_JOINT:
                _describe(channels, f"{joint}_{axis}", joint, kind, unit)
        for joint in hello.names:
            _describe(channels, f"{joint}_reliability", joint, "Confidence", "normalized")
        return info


def _describe(channels: Any, label: str, joint: str, kind: str, unit: str) -> None:
    channel = channels.append_child("channel")
    for key, value in (("label", label), ("marker", joint), ("type", kind), ("unit", unit)):
        channel.append_child_value(key, value)


def _library() -> Any:
    try:
        import pylsl
    except ImportError:
        raise FileError("--lsl needs pylsl: install motionmend[live]") from None
    except RuntimeError as error:  # the wheel has no liblsl for this machine
        raise FileError(f"--lsl: pylsl found no liblsl: {str(error).splitlines()[0]}") from None
    return pylsl
