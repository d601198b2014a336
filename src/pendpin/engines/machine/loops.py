"""Loops around a function, as machine code: steps of the classical Runge-Kutta method, and evaluations at many states.

They take the address of the function, so that a process compiles each of them once, and only if it is called. How many
numbers a state has, and how many unit vectors it begins with, is in the cells STATE, MORE and UNITS of a block.
"""

import ctypes

from pendpin.engines.machine.lines import number
from pendpin.engines.machine.text import MORE, STATE, UNITS

OFF = 1e-14  # of the square of a direction: below, it is left as it is, and the divisions' rounding does not add up

# The first argument is the address of the function; then
# y, t, h, steps, block, work (5 size): moves y on from t by `steps` steps of h; its directions stay unit vectors
Steps = ctypes.CFUNCTYPE(
    None,
    *(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_double),
    *(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p),
)

# n, t (n,), y (n, size), block, dy (n, size), more (n, further results)
Many = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64, *[ctypes.c_void_p] * 5)


def _whole(name: str, cell: int) -> str:
    """A whole number of a block."""
    return f"""
  %{name}_at = getelementptr i64, ptr %cells, i64 {cell}
  %{name} = load i64, ptr %{name}_at"""


MANY = f"""
define void @many(ptr %rate, i64 %n, ptr %t, ptr %y, ptr %block, ptr %dy, ptr %more) {{
entry:
  %cells = load ptr, ptr %block{_whole("size", STATE)}{_whole("size_more", MORE)}
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]
  %row = mul i64 %i, %size
  %row_more = mul i64 %i, %size_more
  %at = getelementptr double, ptr %t, i64 %i
  %time = load double, ptr %at
  %state = getelementptr double, ptr %y, i64 %row
  %rates = getelementptr double, ptr %dy, i64 %row
  %further = getelementptr double, ptr %more, i64 %row_more
  call void %rate(ptr %rates, double %time, ptr %state, ptr %block, ptr %further)
  %after = add i64 %i, 1
  %again = icmp slt i64 %after, %n
  br i1 %again, label %next, label %done
done:
  ret void
}}
"""

STEPS = f"""
declare double @llvm.sqrt.f64(double)

define internal void @along(i64 %size, ptr %out, ptr %y, double %h, ptr %k) {{ ; out = y + h k
entry:
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]
  %from = getelementptr double, ptr %y, i64 %i
  %rate = getelementptr double, ptr %k, i64 %i
  %to = getelementptr double, ptr %out, i64 %i
  %value = load double, ptr %from
  %slope = load double, ptr %rate
  %change = fmul double %h, %slope
  %sum = fadd double %value, %change
  store double %sum, ptr %to
  %after = add i64 %i, 1
  %more = icmp slt i64 %after, %size
  br i1 %more, label %next, label %done
done:
  ret void
}}

define internal void @unit(i64 %units, ptr %y) {{                             ; each of the first vectors of 3
entry:
  %some = icmp slt i64 0, %units
  br i1 %some, label %next, label %done
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]
  %from = mul i64 %i, 3
  %px = getelementptr double, ptr %y, i64 %from
  %py = getelementptr double, ptr %px, i64 1
  %pz = getelementptr double, ptr %px, i64 2
  %x = load double, ptr %px
  %y1 = load double, ptr %py
  %z = load double, ptr %pz
  %xx = fmul double %x, %x
  %yy = fmul double %y1, %y1
  %zz = fmul double %z, %z
  %xy = fadd double %xx, %yy
  %xyz = fadd double %xy, %zz
  %off = fsub double %xyz, 1.0
  %above = fcmp ogt double %off, {number(OFF)}
  %below = fcmp olt double %off, {number(-OFF)}
  %far = or i1 %above, %below
  %root = call double @llvm.sqrt.f64(double %xyz)
  %length = select i1 %far, double %root, double 1.0
  %ux = fdiv double %x, %length
  %uy = fdiv double %y1, %length
  %uz = fdiv double %z, %length
  store double %ux, ptr %px
  store double %uy, ptr %py
  store double %uz, ptr %pz
  %after = add i64 %i, 1
  %more = icmp slt i64 %after, %units
  br i1 %more, label %next, label %done
done:
  ret void
}}

define void @steps(ptr %rate, ptr %y, double %t, double %h, i64 %count, ptr %block, ptr %k1) {{
entry:
  %cells = load ptr, ptr %block{_whole("size", STATE)}{_whole("units", UNITS)}
  %k2 = getelementptr double, ptr %k1, i64 %size
  %k3 = getelementptr double, ptr %k2, i64 %size
  %k4 = getelementptr double, ptr %k3, i64 %size
  %inner = getelementptr double, ptr %k4, i64 %size
  %half = fmul double %h, 0.5
  %sixth = fdiv double %h, 6.0
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]
  %many = sitofp i64 %i to double
  %gone = fmul double %many, %h
  %begin = fadd double %t, %gone
  %middle = fadd double %begin, %half
  %end = fadd double %begin, %h
  call void %rate(ptr %k1, double %begin, ptr %y, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %half, ptr %k1)
  call void %rate(ptr %k2, double %middle, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %half, ptr %k2)
  call void %rate(ptr %k3, double %middle, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %h, ptr %k3)
  call void %rate(ptr %k4, double %end, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %k2, ptr %k2, double 1.0, ptr %k3)
  call void @along(i64 %size, ptr %k1, ptr %k1, double 2.0, ptr %k2)
  call void @along(i64 %size, ptr %k1, ptr %k1, double 1.0, ptr %k4)
  call void @along(i64 %size, ptr %y, ptr %y, double %sixth, ptr %k1)
  call void @unit(i64 %units, ptr %y)
  %after = add i64 %i, 1
  %more = icmp slt i64 %after, %count
  br i1 %more, label %next, label %done
done:
  ret void
}}
"""
