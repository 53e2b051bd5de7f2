"""How fast and how lean: each suite measures the package against its plain twins and against peers, in one run."""
