"""Delete every term of every formula, or take the wrong body, one change at a time: do the exact checks notice?

    python -m tests.mutation.run                 all modules with formulas
    python -m tests.mutation.run dot1 euler      some of them

The checks are those of `tests/elements`, in whole numbers and by complex step. Prints the survivors and the figure; the
exit code is 1 if there is a survivor. Each one is a gap in the checks, or computes the same numbers: then let the
formula be written so that nothing in it can be left out.
"""

import sys
import time

from tests.mutation.mutants import CHECKS, killer, modules, mutants


def main(chosen: list[str]) -> int:
    start, total, by_number, survived = time.perf_counter(), 0, 0, 0
    for check in CHECKS:
        check.run()  # the right formulas must pass, or every mutant would seem to be caught
    for module in modules():
        if chosen and module.rsplit(".", 1)[-1] not in chosen:
            continue
        every = list(mutants(module))
        for mutant in every:
            noticed = killer(mutant)
            by_number += noticed is not None and "wrong number" in noticed
            if noticed is None:
                survived += 1
                print(f"  SURVIVED {mutant}")
        total += len(every)
        print(f"{module}: {len(every)} mutants", flush=True)
    caught, seconds = total - survived, time.perf_counter() - start
    how = f"{by_number} by a wrong number, {caught - by_number} by an error"
    print(f"{caught} of {total} mutants caught ({how}) in {seconds:.0f} s")
    return int(survived > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
