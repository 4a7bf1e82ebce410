"""LAPACK and BLAS for compiled kernels, through the function pointers that scipy publishes.

Matrices are parts of flat arrays, column by column (Fortran order), of square blocks the lower triangles:

    factor            A = L Lᵀ in place                 (dpotrf)
    divide            B ← B L⁻ᵀ  or  B L⁻¹              (dtrsm)
    subtract_square   C ← C − B Bᵀ                      (dsyrk)
    inverse           A⁻¹ from L in place               (dpotri)
    times_symmetric   C ← −S B                          (dsymm)
    subtract_product  C ← C − Aᵀ B                      (dgemm)

The pointers are made known to the linker under names of their own, so that kernels can be kept on disk.
"""

from __future__ import annotations

import llvmlite.binding
import numpy as np
from numba import njit, types
from numba.extending import get_cython_function_address

_DOUBLES, _INTEGERS, _LETTERS = (types.CPointer(t) for t in (types.float64, types.int32, types.uint8))


def _routine(library: str, name: str, arguments: str) -> types.ExternalFunction:
    """A routine by its name; of its arguments c is a letter, i an integer, d a number or an array."""
    kinds = {"c": _LETTERS, "i": _INTEGERS, "d": _DOUBLES}
    llvmlite.binding.add_symbol(
        f"splinebba_{name}", get_cython_function_address(f"scipy.linalg.cython_{library}", name)
    )
    return types.ExternalFunction(f"splinebba_{name}", types.void(*(kinds[a] for a in arguments)))


_dpotrf = _routine("lapack", "dpotrf", "cidii")
_dpotri = _routine("lapack", "dpotri", "cidii")
_dtrsm = _routine("blas", "dtrsm", "cccciiddidi")
_dsyrk = _routine("blas", "dsyrk", "cciiddiddi")
_dsymm = _routine("blas", "dsymm", "cciiddididdi")
_dgemm = _routine("blas", "dgemm", "cciiiddididdi")


@njit(cache=True, nogil=True)
def arguments():
    """Room for the scalar arguments of the routines: letters L R N T, numbers 1 −1 0, integers."""
    letters = np.array([76, 82, 78, 84], dtype=np.uint8)
    return letters, np.array([1.0, -1.0, 0.0]), np.empty(5, dtype=np.int32)


@njit(cache=True, nogil=True)
def factor(scalars, a, n):
    """A = L Lᵀ in place; the number of the first pivot that fails (from 1), or 0."""
    letter, _, i = scalars
    i[0], i[1] = n, 0
    _dpotrf(letter.ctypes, i.ctypes, a.ctypes, i.ctypes, i[1:].ctypes)
    return i[1]


@njit(cache=True, nogil=True)
def inverse(scalars, a, n):
    """A⁻¹ from L in place."""
    letter, _, i = scalars
    i[0], i[1] = n, 0
    _dpotri(letter.ctypes, i.ctypes, a.ctypes, i.ctypes, i[1:].ctypes)


@njit(cache=True, nogil=True)
def divide_transposed(scalars, lower, b, r, n):
    """B ← B L⁻ᵀ, b is r × n."""
    letter, number, i = scalars
    i[0], i[1] = r, n
    _dtrsm(
        letter[1:].ctypes, letter.ctypes, letter[3:].ctypes, letter[2:].ctypes, i.ctypes, i[1:].ctypes,
        number.ctypes, lower.ctypes, i[1:].ctypes, b.ctypes, i.ctypes,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def divide(scalars, lower, b, r, n):
    """B ← B L⁻¹, b is r × n."""
    letter, number, i = scalars
    i[0], i[1] = r, n
    _dtrsm(
        letter[1:].ctypes, letter.ctypes, letter[2:].ctypes, letter[2:].ctypes, i.ctypes, i[1:].ctypes,
        number.ctypes, lower.ctypes, i[1:].ctypes, b.ctypes, i.ctypes,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def subtract_square(scalars, c, b, r, n):
    """C ← C − B Bᵀ, b is r × n, c r × r."""
    letter, number, i = scalars
    i[0], i[1] = r, n
    _dsyrk(
        letter.ctypes, letter[2:].ctypes, i.ctypes, i[1:].ctypes, number[1:].ctypes, b.ctypes, i.ctypes,
        number.ctypes, c.ctypes, i.ctypes,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def times_symmetric(scalars, c, s, b, r, n):
    """C ← −S B, s is r × r, b and c r × n."""
    letter, number, i = scalars
    i[0], i[1] = r, n
    _dsymm(
        letter.ctypes, letter.ctypes, i.ctypes, i[1:].ctypes, number[1:].ctypes, s.ctypes, i.ctypes,
        b.ctypes, i.ctypes, number[2:].ctypes, c.ctypes, i.ctypes,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def subtract_product(scalars, c, a, b, r, n):
    """C ← C − Aᵀ B, a and b are r × n, c n × n."""
    letter, number, i = scalars
    i[0], i[1] = r, n
    _dgemm(
        letter[3:].ctypes, letter[2:].ctypes, i[1:].ctypes, i[1:].ctypes, i.ctypes, number[1:].ctypes,
        a.ctypes, i.ctypes, b.ctypes, i.ctypes, number.ctypes, c.ctypes, i[1:].ctypes,
    )  # fmt: skip
