"""Command line of the optimisation: `python -m phalanx.optimize STUDY --out front.parquet`."""

import sys

from .optimization import optimize

if __name__ == "__main__":
    from .optimization.command import main

    sys.exit(main())
# `import phalanx.optimize` must not hide the function `phalanx.optimize`.
sys.modules[__name__] = optimize  # type: ignore[assignment]
