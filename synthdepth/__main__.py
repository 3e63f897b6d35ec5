"""`python -m synthdepth` is the command line."""

import sys

from synthdepth.cli import main

if __name__ == "__main__":
    sys.exit(main())
