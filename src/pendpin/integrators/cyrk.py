"""CyRK's solver in C++, without importing CyRK: that imports Numba, 0.17 to 0.3 s where a first run takes 0.1 s.

CyRK documents nbsolve2_ivp, which Numba compiles for each caller, and no way to its solver without that import (0.20: the
module that holds the addresses imports the package). So its functions are found by their C++ names, which spell out the
types of the arguments: a CyRK with another interface is not taken, and a note says so. The numbers of the methods are
those of the versions named in SERIES.
"""

from contextlib import suppress
from ctypes import c_bool, c_double, c_int, c_size_t, c_void_p
from functools import cache
from importlib.util import find_spec
from typing import Any

from pendpin.engines.machine import llvm
from pendpin.errors import say_note
from pendpin.ground.libraries import c_functions, version

SERIES = "0.20."
# The places of CyRK's enum ODEMethod, which no exported function tells: a new series has to be looked at before it is used.
METHODS = {"RK23": 3, "RK45": 4, "DOP853": 5, "BDF": 6, "LSODA": 7, "Radau": 8}

_RATE_TIMES_STATE = (c_void_p, c_double, c_double, c_void_p, c_size_t)
_SIZES = (c_int, c_size_t, c_size_t, c_void_p, c_size_t, c_size_t, c_size_t, c_bool)
_OUTPUT_EVENTS = (c_void_p, c_size_t, c_void_p, c_void_p, c_size_t)
_TOLERANCES_STEPS = (c_void_p, c_size_t, c_void_p, c_size_t, c_double, c_double, c_bool)
# As `nm -D --defined-only` prints them for CyRK's nb/numba_c_api*.so. The letters behind a function's name are the types of
# its arguments (c++filt writes them out), so that a changed argument changes the name, and the symbol is not found.
_NAMES: dict[str, tuple[str, Any, tuple[Any, ...]]] = {  # C++ name, type of the result, types of the arguments
    "solve": (
        "_Z17numba_cysolve_ivpPFvPddS_PcPFvS0_dS_S0_EEddS_m9ODEMethodmmS0_mmmbS_mS2_P5EventmS_mS_mddb",
        c_void_p,
        _RATE_TIMES_STATE + _SIZES + _OUTPUT_EVENTS + _TOLERANCES_STEPS,
    ),
    "free": ("_Z13cysolver_freePv", None, (c_void_p,)),
    "success": ("_Z20cysolver_get_successPv", c_bool, (c_void_p,)),
    "steps": ("_Z24cysolver_get_steps_takenPv", c_size_t, (c_void_p,)),
    "size": ("_Z17cysolver_get_sizePv", c_size_t, (c_void_p,)),
    "times": ("_Z18cysolver_get_t_ptrPv", c_void_p, (c_void_p,)),
    "states": ("_Z18cysolver_get_y_ptrPv", c_void_p, (c_void_p,)),
    "inside": ("_Z28cysolver_call_call_vectorizePvPKdmPd", c_int, (c_void_p, c_void_p, c_size_t, c_void_p)),
    "message": ("_Z27cysolver_get_message_bufferPvPcm", None, (c_void_p, c_void_p, c_size_t)),
}


@cache
def library() -> Any:
    """The functions by the names above; None if this CyRK, or this processor, does not have them: with a note, once."""
    if not installed():
        return None
    found, reason = version("CyRK"), "this processor has no AVX2"
    features = llvm.processor().features.split(b",")
    if b"-avx2" not in features:  # which CyRK for x86 needs; others have no such feature to lack
        reason = f"pendpin uses CyRK {SERIES}x: pip install 'CyRK=={SERIES}*'"
        with suppress(OSError, AttributeError, ValueError):
            if found.startswith(SERIES):
                return c_functions("CyRK", "nb/numba_c_api.*.so", _NAMES)
    say_note(f"CyRK {found} is not used, and runs take about 8 times as long: {reason}", stacklevel=3)
    return None


def installed() -> bool:
    """Whether CyRK is there, without importing it."""
    return find_spec("CyRK") is not None
