"""`python -m fitter.bench.memory TABLE MODEL`: the peak memory of a fit over its loaded data, as JSON."""

from __future__ import annotations

import gc
import json
import pathlib
import sys

_MB = 1e6


def main(path: str, model: str) -> None:
    """Prints `loaded`, `first` and `second`; see `Memory`."""
    from .. import read
    from .resources import fit

    data = read(path)
    gc.collect()
    loaded = _restart()
    fit(model, data)
    first = _peak() - loaded
    gc.collect()
    _restart()
    fit(model, data)
    print(json.dumps({"loaded": loaded / _MB, "first": first / _MB, "second": (_peak() - loaded) / _MB}))


def _restart() -> float:
    """The bytes held now, from which the peak is counted anew where the system can do that (Linux): the reader's own
    peak must not hide the fit's."""
    reset = pathlib.Path("/proc/self/clear_refs")
    if not reset.exists():
        return _peak()
    reset.write_text("5")
    return _peak()


def _peak() -> float:
    """The largest number of bytes held so far."""
    status = pathlib.Path("/proc/self/status")
    if status.exists():
        peak = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return 1024 * float(peak.split()[1])
    import resource

    # Bytes on macOS, kilobytes elsewhere.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


if __name__ == "__main__":
    main(*sys.argv[1:])
