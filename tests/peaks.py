"""How much memory a command takes, in a process of its own."""

import json
import subprocess
import sys

# As many threads, and what they work on, on every machine.
CALL = (
    "import os, sys; os.sched_getaffinity = lambda _: {0, 1}; "
    "from facezip.cli import facezip; from facezip.machine.conditions import peak_memory; "
    "facezip.main(standalone_mode=False); print(peak_memory(), file=sys.stderr)"
)


def peak_of(*line):
    """Bytes at the peak of ``facezip LINE --json``, and the document that it prints."""
    command = [sys.executable, "-c", CALL, *map(str, line), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=250, check=True)
    return int(done.stderr.split()[-1]), json.loads(done.stdout)
