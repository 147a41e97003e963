"""numpy as np, or a word on where to get it."""
import sys

try:
    import numpy as np  # noqa: F401  (handed on)
except ModuleNotFoundError:
    print(f"error: {sys.executable} has no numpy: install it (Debian: python3-numpy), or run the script with a Python that has it, "
          "for example /usr/bin/python3", file=sys.stderr)
    sys.exit(2)
