#!/usr/bin/env bash
# Packs a program with GPU support for another x86-64 Linux machine:
# `bundle.sh PROGRAM FOLDER`. The folder then holds the program, the libraries
# that it needs but for glibc and the driver, CUDA's runtime, the packings, and
# bench-gpu, which measures. cuBLAS (1 GB) is left out unless BUNDLE_CUBLAS is 1: the
# target then needs one of the same major version.
set -euo pipefail
top="$(cd "$(dirname "$0")/.." && pwd)"
program="$1"
folder="$2"
rm -rf "$folder"
mkdir -p "$folder/bin/lib" "$folder/packings"
cp "$program" "$folder/bin/dempfv"
strip --strip-debug "$folder/bin/dempfv"

# glibc is the target's own: a loader and a libc must be of one piece.
glibc='^(linux-vdso|ld-linux|libc|libm|libdl|librt|libpthread|libresolv|libmvec)[.-]'
ldd "$program" | awk '$3 ~ /^\// { print $1, $3 }' | while read -r name path; do
    if [[ ! "$name" =~ $glibc ]]; then cp -L "$path" "$folder/bin/lib/$name"; fi
done

# Of the version that it was built with; an installation has its libraries in lib64.
cuda="$("$top/cholmod-sys/cuda/find.sh" "$top/cuda")"
major="$(sed -n 's/^#define CUDART_VERSION *\([0-9]*\)[0-9]\{3\}.*/\1/p' "$cuda/include/cuda_runtime_api.h")"
library() {
    for place in "$cuda/lib64" "$cuda/lib"; do
        if [ -e "$place/$1.so.$major" ]; then
            cp -L "$place/$1.so.$major" "$folder/bin/lib/"
            return
        fi
    done
    echo "$1.so.$major is not in $cuda" >&2
    exit 1
}
library libcudart
if [ "${BUNDLE_CUBLAS:-0}" = 1 ]; then
    library libcublas
    library libcublasLt
fi

cat > "$folder/dempfv" <<'LAUNCHER'
#!/bin/sh
# Starts the program with the libraries beside it.
here="$(cd "$(dirname "$(readlink -f "$0")")" && pwd)"
LD_LIBRARY_PATH="$here/bin/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" exec "$here/bin/dempfv" "$@"
LAUNCHER
chmod +x "$folder/dempfv"
cp "$top"/packings/oedometer-*.txt "$folder/packings/"
cp "$top/gpu/bench-gpu" "$folder/"
cp "$top/LICENSE" "$folder/"
"$folder/dempfv" doctor > "$folder/doctor.txt"
du -sh "$folder"
