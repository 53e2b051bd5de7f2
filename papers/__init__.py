"""The published claims, run again: `run` measures each one on real recordings and writes a report.

`claims.toml` (denoising), `tracking.toml` and `correcting.toml` say what was claimed, where, and what counts as met; one
script per figure or table measures it. `beyond.toml` does the same for what the package sets itself beyond the papers.
"""

from .harness import run

__all__ = ["run"]
