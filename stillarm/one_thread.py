"""Linear algebra on one thread."""

import os


def one_blas_thread() -> None:
    """Keep numpy's linear algebra on one thread, unless the environment says otherwise. Call before numpy is imported.

    On the small matrices of a fit, a second thread costs more than it gives (twice the time on two cores), and
    sums in another order, so that what is found would depend on the machine.
    """
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
