"""Write what the program says about the broken projects of the catalogue: ``python -m tests.bad_input.regenerate``."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from tests.bad_input.cases import all_cases, findings, fits


def main() -> int:
    """Write snapshots of all cases, or of those named; list those that do not point at their mistake."""
    wanted, wrong = sys.argv[1:], 0
    for case in all_cases():
        if wanted and case.name not in wanted:
            continue
        with tempfile.TemporaryDirectory() as folder:
            expected = case.written(Path(folder))
            code, output = case.run(Path(folder))
        case.snapshot.write_text(f"{output.rstrip()}\nexit code {code}\n", encoding="utf-8")
        said = findings(output)
        if code != case.exit_code or len(said) != len(expected) or not all(map(fits, said, expected)):
            wrong += 1
            print(f"{case.name}: exit code {code}\n  said     {said}\n  expected {expected}")
    print(f"{wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
