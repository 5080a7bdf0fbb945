"""`python -m overcoat` is the command `overcoat`."""

import sys

from ._command import main

sys.exit(main())
