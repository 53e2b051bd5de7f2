"""A small person in Acclaim's format that tests share: its .asf, frames of it, and a folder that holds them."""

from pathlib import Path

from motionmend.bodies.motion import Motion
from motionmend.io.amc import read_amc
from motionmend.io.asf import INCH

ASF = """# a small person
:version 1.10
:name SMALL
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   Notes of any kind,
   (with brackets) and words like dof.
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name leg
     direction 0 -1 0
     length 15
     axis 0 0 20 XYZ
    dof rx rz
    limits (-160.0 20.0)
           (-inf inf)
  end
  begin
     name foot
     length 2
     dof rx
     axis -90 0 20 ZYX
     direction 0 0 1
     limits (-45 90)
     bodymass 3
  end
  begin
     id 3
     name hip
     direction 1 0 0
     length 1.5
     axis 0 0 0 XYZ
  end
  begin
     id 4
     name head
     direction 0 1 0
     length 14
     axis 0 0 0 XYZ
     dof rx ry rz
     limits (-20 45) (-30 30) (-30 30)
  end
:hierarchy
  begin
    root hip head
    hip leg
    leg foot
  end
"""
HEADER = "#!OML:ASF small.ASF\n:FULLY-SPECIFIED\n:DEGREES\n"
FRAMES = """1
root 1 16 3 10 20 30
head 1.5 -2 3e-1
leg -20 5.25
foot 7
2
root 1.1 16.1 3.1 11 21 31
head 1.6 -2.1 -1.2e-014
leg -21 5.5
foot 7.5
3
root 1.2 16.2 3.2 12 22 32
head 1.7 -2.2 1
leg -22 5.75
foot 8
"""
UNIT = INCH / 0.45


def read_frames(folder: Path, text: str, **options) -> Motion:
    path = folder / "small_01.amc"
    path.write_bytes(text.encode())
    return read_amc(path, **options)
