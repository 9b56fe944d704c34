"""Compilation of kernels: its flags, its cache between processes, and a notice while it runs."""

from __future__ import annotations

import hashlib
import logging
import sys
from collections.abc import Callable
from functools import cache
from importlib import resources
from typing import Any

import numba
import numba.core.event
from llvmlite import binding
from numba.core.caching import FunctionCache, IndexDataCacheFile

_logger = logging.getLogger("geomstats_anim")

_can_cache = True


def _import_without_blas() -> None:
    """Import what Numba imports on the first call anyway, but not SciPy's BLAS: that takes as long as all of Numba."""
    blas = "scipy.linalg.cython_blas"
    if blas in sys.modules:
        return
    sys.modules[blas] = None  # type: ignore[assignment]
    try:
        from numba.np import arraymath
    finally:
        del sys.modules[blas]
    # SciPy is there; Numba asks for BLAS again where a function needs it, and no kernel of this folder does.
    arraymath._HAVE_BLAS = True


_import_without_blas()


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a kernel on first use, and cache it until any kernel of this folder changes."""
    # without fast math, and so without fused multiply-adds, every compilation on every machine rounds the same way
    kernel: Any = numba.njit(nogil=True, error_model="numpy")(function)
    try:
        kernel._cache = _KernelCache(function)
    except RuntimeError:  # no folder is writable
        global _can_cache
        _can_cache = False
    return kernel


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into every kernel that calls it, for what is called so often that the call itself counts."""
    return numba.njit(nogil=True, error_model="numpy", forceinline=True)(function)


class _KernelCache(FunctionCache):
    """Numba's cache, in Numba's folders, with keys that cover all kernels, which are compiled into one another."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._cache_file = _KernelFiles(self._cache_path, self._impl.filename_base, _source_stamp())


class _KernelFiles(IndexDataCacheFile):
    """One file per key, so that no other version, signature or process ever writes over it."""

    def save(self, key: Any, data: Any) -> None:
        self._save_data(self._name(key), data)

    def load(self, key: Any) -> Any:
        try:
            return self._load_data(self._name(key))
        except FileNotFoundError:
            return None

    def _name(self, key: Any) -> str:
        digest = hashlib.sha256(repr((self._source_stamp, key)).encode()).hexdigest()
        return self._data_name_pattern.format(number=int(digest[:16], 16))


@cache
def _source_stamp() -> str:
    """Hash the kernels' sources, the compiler's version and the processor."""
    digest = hashlib.sha256(numba.__version__.encode())
    digest.update(binding.get_host_cpu_name().encode() + binding.get_host_cpu_features().flatten().encode())
    sources = (file for file in resources.files(__package__).iterdir() if file.name.endswith(".py"))
    for file in sorted(sources, key=lambda file: file.name):
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()


class _Notice(numba.core.event.Listener):
    """Log once per process that a kernel of this package is compiled rather than loaded."""

    def __init__(self) -> None:
        self._is_given = False

    def on_start(self, event: numba.core.event.Event) -> None:
        module = event.data["dispatcher"].py_func.__module__
        if not self._is_given and module.partition(".")[0] == "geomstats_anim":
            self._is_given = True
            how_often = (
                "once for this installation"
                if _can_cache
                else "in every process, as no cache folder is writable; set NUMBA_CACHE_DIR to one that is"
            )
            _logger.warning("Compiling the geodesic kernels: about ten seconds, %s.", how_often)

    def on_end(self, event: numba.core.event.Event) -> None:
        """Log nothing."""


numba.core.event.register("numba:compile", _Notice())
