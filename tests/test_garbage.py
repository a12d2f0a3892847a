"""The pause of garbage collection ends, in child processes too."""

import gc
import os
import subprocess
import sys

import pytest

from sarrus.garbage import uncollected

FORK = """
import gc, os, threading
from sarrus.garbage import uncollected

begun, over = threading.Event(), threading.Event()

def load():
    with uncollected():
        begun.set()
        over.wait()

thread = threading.Thread(target=load)
thread.start()
begun.wait()
assert not gc.isenabled()
child = os.fork()
if not child:
    os._exit(0 if gc.isenabled() else 1)
_, status = os.waitpid(child, 0)
assert not gc.isenabled()
over.set()
thread.join()
assert gc.isenabled()
raise SystemExit(os.waitstatus_to_exitcode(status))
"""


def test_collection_is_as_it_was() -> None:
    with uncollected(), uncollected():
        assert not gc.isenabled()
    assert gc.isenabled()
    gc.disable()
    try:
        with uncollected():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_child_collects_though_another_thread_had_paused_it() -> None:
    assert (
        subprocess.run([sys.executable, "-W", "ignore", "-c", FORK], timeout=60, check=False).returncode == 0
    )
