"""Counts how often Python's allocators are called, exactly: each is led past a counter of a few machine instructions.

The interpreter lets its allocators be replaced (PyMem_SetAllocator, Include/cpython/pymem.h). What replaces them may
allocate nothing itself, so it is compiled, with llvmlite, which comes with numba. Objects from a free list of the
interpreter, such as most floats, need no allocator and are not counted.
"""

import contextlib
import ctypes
from array import array
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

_DOMAINS = (1, 2)  # PYMEM_DOMAIN_MEM, PYMEM_DOMAIN_OBJ: all that is called with the interpreter's lock held
_FUNCTIONS = (("malloc", 2), ("calloc", 3), ("realloc", 3))  # with their number of arguments, each of a word


class _Allocator(ctypes.Structure):
    """PyMemAllocatorEx."""

    _fields_ = [
        ("context", ctypes.c_void_p),
        *((name, ctypes.c_void_p) for name, _ in _FUNCTIONS),
        ("free", ctypes.c_void_p),
    ]


def countable() -> bool:
    """Whether the compiler is installed."""
    return find_spec("llvmlite") is not None


class AllocationCounter:
    """The count, while counting() is entered."""

    def __init__(self) -> None:
        """Compile; changes nothing. Raises ModuleNotFoundError without llvmlite."""
        self._count = array("Q", [0])
        self._engines: list[Any] = []  # hold the compiled code
        self._plain = {domain: _allocator(domain) for domain in _DOMAINS}
        self._counted = {domain: self._compiled(plain) for domain, plain in self._plain.items()}

    def count(self) -> int:
        """Calls of malloc, calloc and realloc so far."""
        return self._count[0]

    @contextlib.contextmanager
    def counting(self) -> Iterator[None]:
        """Count in this block."""
        for domain, allocator in self._counted.items():
            ctypes.pythonapi.PyMem_SetAllocator(domain, ctypes.byref(allocator))
        try:
            yield
        finally:
            for domain, allocator in self._plain.items():
                ctypes.pythonapi.PyMem_SetAllocator(domain, ctypes.byref(allocator))

    def _compiled(self, plain: _Allocator) -> _Allocator:
        """An allocator that counts, and calls `plain`."""
        from llvmlite import binding, ir

        binding.initialize_native_target()
        binding.initialize_native_asmprinter()
        module, word = ir.Module("counted"), ir.IntType(8 * ctypes.sizeof(ctypes.c_void_p))
        counter = ir.Constant(word, self._count.buffer_info()[0])
        for name, arguments in _FUNCTIONS:
            kind = ir.FunctionType(word, [word] * arguments)
            function = ir.Function(module, kind, name)
            code = ir.IRBuilder(function.append_basic_block())
            place = code.inttoptr(counter, word.as_pointer())
            code.store(code.add(code.load(place), ir.Constant(word, 1)), place)
            called = code.inttoptr(ir.Constant(word, getattr(plain, name)), kind.as_pointer())
            code.ret(code.call(called, list(function.args)))
        machine = binding.Target.from_default_triple().create_target_machine()
        engine = binding.create_mcjit_compiler(binding.parse_assembly(str(module)), machine)
        engine.finalize_object()
        self._engines.append(engine)
        addresses = (engine.get_function_address(name) for name, _ in _FUNCTIONS)
        return _Allocator(plain.context, *addresses, plain.free)


def _allocator(domain: int) -> _Allocator:
    allocator = _Allocator()
    ctypes.pythonapi.PyMem_GetAllocator(domain, ctypes.byref(allocator))
    return allocator
