"""The pause of garbage collection ends, in child processes too, and loses nothing; nor does the end of a process."""

import gc
import os
import subprocess
import sys
from pathlib import Path

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


OLD = """
import gc, weakref
from sarrus.garbage import uncollected

class Circle:
    def __init__(self):
        self.own = self

gc.collect()
with uncollected():
    made = Circle()
assert any(found is made for found in gc.get_objects(generation=2))
found = weakref.ref(made)
del made
gc.collect()
assert found() is None
"""


def test_what_a_pause_made_is_old_but_can_be_collected() -> None:
    """In a process of its own, which has few objects to look at."""
    subprocess.run([sys.executable, "-W", "ignore", "-c", OLD], timeout=60, check=True)


FROZEN = """
import gc
from sarrus.garbage import uncollected

with uncollected():
    pass
assert gc.get_freeze_count() == 0
gc.freeze()
count = gc.get_freeze_count()
for _ in range(2):
    with uncollected():
        pass
    assert gc.get_freeze_count() == count > 0
"""


def test_what_the_user_has_frozen_stays_so() -> None:
    """In a process of its own: those of tests have frozen objects already."""
    subprocess.run([sys.executable, "-W", "ignore", "-c", FROZEN], timeout=60, check=True)


CIRCLE = """
import sarrus.garbage

class Circle:
    def __init__(self, path):
        self.own, self.file = self, open(path, {mode!r})

Circle({path!r}).file.write({content!r})
"""


@pytest.mark.parametrize("content", ["written", b"written"])
def test_files_of_objects_that_are_not_freed_are_written(content: str | bytes, tmp_path: Path) -> None:
    path = tmp_path / "file"
    program = CIRCLE.format(path=str(path), mode="wb" if isinstance(content, bytes) else "w", content=content)
    subprocess.run([sys.executable, "-W", "ignore", "-c", program], check=True)
    assert path.read_bytes() == b"written"
