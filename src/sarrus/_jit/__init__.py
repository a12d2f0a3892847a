"""How kernels are recorded, compiled and cached: the only place that knows Numba and LLVM."""
