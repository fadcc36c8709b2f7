# The libraries that YADE says it is built from; none where it does not tell. The kernels of
# OpenBLAS are those that it has chosen in this process.
import ctypes

try:
    from yade import libVersions

    found = libVersions.getAllVersionsCpp()
except ImportError:
    found = {}
wanted = ["cgal", "suitesparse", "metis", "openblas", "eigen", "compiler"]
told = {name: found[name][1].strip() for name in wanted if found.get(name)}
with open("/proc/self/maps") as maps:
    files = {line.split()[-1] for line in maps if "libopenblas" in line}
for file in files:
    name = ctypes.CDLL(file).openblas_get_corename
    name.restype = ctypes.c_char_p
    told["openblas"] = f"{told.get('openblas', 'OpenBLAS')}, {name().decode()} kernels"
finish(told)
