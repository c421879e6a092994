"""For all tests: linear algebra on one thread, as the commands have it, and no example timed, whatever the machine."""

from common.blas_threads import one_blas_thread

one_blas_thread()

from hypothesis import settings  # noqa: E402 - nothing may load NumPy before

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

pytest_plugins = ("pytester", "tests.plugins.blind_slices", "tests.plugins.quick_tests")
