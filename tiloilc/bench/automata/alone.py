"""One translation, measured with its memory: `python -m tiloilc.bench.automata.alone FORMULA`."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path

from tiloilc.bench.automata.measure import measure


def peak_memory() -> float:
    """The most memory that this process has had, in MiB; 0 where the system does not tell."""
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        pass
    else:  # not getrusage: on Linux that counts the process before exec as well
        fields = dict(line.split(":", 1) for line in status.splitlines() if ":" in line)
        return int(fields["VmHWM"].split()[0]) / 1024
    try:
        import resource
    except ImportError:
        return 0.0
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return used / (1 << 20) if sys.platform == "darwin" else used / 1024


def main() -> None:
    """Print what was measured as one JSON object."""
    measured = measure(sys.argv[1], "state", runs=1)
    sys.stdout.write(json.dumps({**asdict(measured), "peak": peak_memory()}))


if __name__ == "__main__":
    main()
