#!/usr/bin/env bash
# Builds the stand-in for CUDA's libraries into a folder:
# `build.sh CUDA_INCLUDE FOLDER`. For tests alone; see standin.h.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
include="$1"
mkdir -p "$2"
major="$(sed -n 's/^#define CUDART_VERSION *\([0-9]*\)[0-9]\{3\}.*/\1/p' "$include/cuda_runtime_api.h")"
make_library() {
    cc -O2 -Wall -Wextra -shared -fPIC -I "$include" -I "$here/../include" "$here/$1.c" -o "$3/$2" "${@:4}"
}
make_library cudart "libcudart.so.$major" "$2" -lpthread
make_library cublas "libcublas.so.$major" "$2" -lblas
make_library cuda libcuda.so.1 "$2"
