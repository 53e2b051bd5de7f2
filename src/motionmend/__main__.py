"""`python -m motionmend` is the command line."""

import sys

if __name__ == "__main__":
    try:
        from .cli import main

        code = main()
    except KeyboardInterrupt:  # before it could say so itself
        print("motionmend: interrupted", file=sys.stderr)
        code = 130
    # CPython ends a module that was run by the signal, whatever it returns, if the last text that it executed (as for
    # each dataclass that is imported) was interrupted: it is none any more once another has been.
    exec("")
    sys.exit(code)
