"""For all tests: linear algebra on one thread, as the commands have it, whatever the machine."""

from common.blas_threads import one_blas_thread

one_blas_thread()
