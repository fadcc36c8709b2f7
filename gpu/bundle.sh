#!/usr/bin/env bash
# Packs a program with GPU support for another x86-64 Linux machine:
# `bundle.sh PROGRAM FOLDER`. The folder then holds the program, the libraries
# that it needs but for glibc and the driver, CUDA's runtime, the packings, and
# bench-gpu, which measures. cuBLAS (1 GB) is left out unless BUNDLE_CUBLAS is 1:
# most machines with a GPU have it.
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

cuda="$top/cuda/toolkit/nvidia/cu13/lib"
for installed in "${CUDA_PATH:-}" "${CUDA_HOME:-}" /usr/local/cuda; do
    if [ -n "$installed" ] && [ -d "$installed/lib64" ]; then cuda="$installed/lib64"; fi
done
cp -L "$cuda"/libcudart.so.[0-9][0-9] "$folder/bin/lib/"
if [ "${BUNDLE_CUBLAS:-0}" = 1 ]; then
    cp -L "$cuda"/libcublas.so.[0-9][0-9] "$cuda"/libcublasLt.so.[0-9][0-9] "$folder/bin/lib/"
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
