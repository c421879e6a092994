"""For all tests: linear algebra on one thread, as the commands have it, whatever the machine."""

from stillarm.one_thread import one_blas_thread

one_blas_thread()
