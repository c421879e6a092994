"""Compiles the arm's functions: cached on disk, without the interpreter's lock, with records as arguments.

A record is a pointer to named numbers; for several records it points to the first, and `nth` gives the others. Arrays
are counted references, counted twice in each call that passes one on: with records a cycle is ten times as fast.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar, cast

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

Function = TypeVar("Function", bound=Callable[..., Any])


def _as_they_are(files: Iterable[Path]) -> tuple[tuple[str, int, int], ...]:
    return tuple((one.name, one.stat().st_mtime_ns, one.stat().st_size) for one in files)


SOURCES = _as_they_are(sorted(Path(__file__).parent.glob("*.py")))
"""Files of which the compiled code is made, as they are."""


def compiled(function: Function) -> Function:
    """Compile on first use."""
    return cast(Function, _kept(njit(cache=True, nogil=True, error_model="numpy")(function)))


def inlined(function: Function) -> Function:
    """The same, inlined into its callers: for what a cycle always passes through."""
    kept = _kept(njit(cache=True, nogil=True, error_model="numpy", forceinline=True)(function))
    return cast(Function, kept)


def compiled_from(*files: str) -> Callable[[Function], Function]:
    """`compiled` for a function elsewhere that calls the arm's. files: its own, and others that it is made of."""
    more = _as_they_are(Path(one) for one in files)

    def decorate(function: Function) -> Function:
        return cast(Function, _kept(njit(cache=True, nogil=True, error_model="numpy")(function), more))

    return decorate


def _kept(dispatcher: Any, more: tuple[tuple[str, int, int], ...] = ()) -> Any:
    """The function, kept on disk until any of the arm's files changes, or of `more`. numba looks at the function's own
    file alone, and goes on with old code where a function that is compiled into it has changed in another."""
    dispatcher._cache._cache_file._source_stamp = SOURCES + more
    return dispatcher


def _nth(typing_context: Any, first: Any, place: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        width = ir.Constant(values[1].type, signature.args[0].size)
        start = builder.bitcast(values[0], ir.IntType(8).as_pointer())
        return builder.bitcast(builder.gep(start, [builder.mul(values[1], width)]), values[0].type)

    return first(first, types.intp), generate


def _call(typing_context: Any, address: Any, arguments: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        double = ir.DoubleType()
        count = signature.args[1].count
        pointer = builder.inttoptr(values[0], ir.FunctionType(double, [double] * count).as_pointer())
        return builder.call(pointer, [builder.extract_value(values[1], place) for place in range(count)])

    return types.float64(address, arguments), generate


nth: Callable[[Any, int], Any] = cast(Any, intrinsic(_nth))
"""Record number `place` (from 0) of those that begin with `first`. Nothing is checked."""
call: Callable[[int, tuple[float, ...]], float] = cast(Any, intrinsic(_call))
"""Call the function of floats at an address with a tuple of them."""
