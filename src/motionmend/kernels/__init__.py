"""The hot loops: arrays in, arrays out, no classes and no validation.

Each kernel has a plain NumPy twin in `tests/naive.py`. Import these modules where they are first used: numba
takes longer to load than the rest of the package together.
"""
