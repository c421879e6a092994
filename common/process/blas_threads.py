"""Linear algebra on one thread."""

import os

BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables of the environment that numpy's linear algebra reads once, when it is imported."""


def one_blas_thread() -> None:
    """Keep numpy's linear algebra on one thread, unless the environment says otherwise. Call before numpy is imported.

    A second thread has no place in the controller's loop. On the small matrices of a fit it costs more than it gives
    (twice the time on two cores), and sums in another order, so that what is found would depend on the machine.
    """
    for name in BLAS_THREADS:
        os.environ.setdefault(name, "1")
