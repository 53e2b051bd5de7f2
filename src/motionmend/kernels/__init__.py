"""The hot loops: arrays and tuples of them in, arrays out, no validation.

Each kernel has a plain NumPy twin in `tests/naive.py`. Import these modules where they are first used: numba
takes longer to load than the rest of the package together.
"""
