"""numba, with a cache on disk of which no damage and no full disk stops a run."""

from contextlib import suppress
from pathlib import Path

from numba import njit
from numba.core.caching import FunctionCache


class PatientCache(FunctionCache):
    """What cannot be read is dropped and compiled anew; what cannot be written is not kept."""

    def load_overload(self, sig, target_context):
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # pickle raises many kinds
            self._drop()

    def save_overload(self, sig, data):
        try:
            super().save_overload(sig, data)
        except Exception:
            self._drop()  # it may name data of an older numba

    def _drop(self):
        with suppress(OSError):
            Path(self._cache_file._index_path).unlink()


def compiled(function, cache, inline):
    """The function compiled when first called; `cache` tells whether its source is a file."""
    dispatcher = njit(nogil=True, error_model="numpy", forceinline=inline)(function)
    if cache:
        with suppress(RuntimeError, OSError):  # numba finds no folder for its cache
            dispatcher._cache = PatientCache(function)
    return dispatcher
