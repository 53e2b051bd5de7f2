"""A small Biovision file, as text that tests change."""

from pathlib import Path

from motionmend.bodies.motion import Motion
from motionmend.io.bvh import read_bvh

HIERARCHY = """HIERARCHY
ROOT Hips
{
\tOFFSET 0.0 0.0 0.0
\tCHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
\tJOINT Head
\t{
\t\tOFFSET 0 70 0
\t\tCHANNELS 3 Yrotation Xrotation Zrotation
\t\tEnd Site
\t\t{
\t\t\tOFFSET 0 15 0
\t\t}
\t}
\tJOINT LeftFoot
\t{
\t\tOFFSET 10 -80 0
\t\tCHANNELS 1 Xrotation
\t\tEnd Site
\t\t{
\t\t\tOFFSET 0 -5 20
\t\t}
\t}
}
"""
VALUES = """0 90 0 10 20 30 1 2 3 4
0.5 90.25 1 11 21 31 1.5 2.5 3.5 4.5
1 90.5 2 12 22 32 2 3 4 5
"""
TEXT = HIERARCHY + "MOTION\nFrames: 3\nFrame Time: 0.00833333\n" + VALUES


def read_text(folder: Path, text: str, **options) -> Motion:
    path = folder / "small.bvh"
    path.write_bytes(text.encode())
    return read_bvh(path, **options)
