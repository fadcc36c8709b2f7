#!/bin/sh
# Prints the folder of CUDA that the feature `cuda` is built with: `find.sh FOLDER`.
# That of CUDA_PATH or CUDA_HOME; else the system's; else what fetch.sh has put
# into FOLDER. The build script goes by the same rule.
chosen="${CUDA_PATH:-${CUDA_HOME:-}}"
for cuda in ${chosen:-/usr/local/cuda "$1/toolkit/nvidia/cu13"}; do
    if [ -x "$cuda/bin/nvcc" ] && [ -f "$cuda/include/cuda_runtime.h" ]; then
        echo "$cuda"
        exit 0
    fi
done
echo "CUDA's compiler was not found in ${chosen:-/usr/local/cuda or $1}" >&2
exit 1
