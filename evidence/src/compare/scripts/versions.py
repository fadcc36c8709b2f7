# The libraries that YADE says it is built from; none where it does not tell.
try:
    from yade import libVersions

    found = libVersions.getAllVersionsCpp()
except ImportError:
    found = {}
wanted = ["cgal", "suitesparse", "metis", "openblas", "eigen", "compiler"]
finish({name: found[name][1].strip() for name in wanted if found.get(name)})
