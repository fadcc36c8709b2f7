#!/usr/bin/env bash
# Fetches what the feature `cuda` is built from and this machine lacks, into a
# folder: `fetch.sh FOLDER`. All of it is checked against hashes that are kept
# here, and put in its place when it is complete; what is there is not fetched
# again.
#
#   suitesparse  the sources of SuiteSparse, which a published crate carries
#   toolkit      CUDA's compiler and headers, from NVIDIA's Python packages,
#                unless there is a CUDA in CUDA_PATH, CUDA_HOME or
#                /usr/local/cuda; with cuBLAS where there is a driver without it,
#                or BUNDLE_CUBLAS is 1
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
mkdir -p "$1"
folder="$(cd "$1" && pwd)"
work="$(mktemp -d "$folder/fetch.XXXXXX")"
trap 'rm -rf "$work"' EXIT

if [ ! -d "$folder/suitesparse" ] && [ -z "${SUITESPARSE_SOURCE:-}" ]; then
    echo "fetching the sources of SuiteSparse"
    cp "$here/sources.toml" "$work/Cargo.toml"
    cp "$here/sources.lock" "$work/Cargo.lock"
    touch "$work/nothing.rs"
    (cd "$work" && cargo vendor --quiet --locked crates > /dev/null)
    mv "$work/crates/suitesparse_sys/vendor" "$folder/suitesparse"
fi

# Installs Python packages by a list with hashes into a folder.
install() {
    python3 -m venv "$work/venv"
    "$work/venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps \
        --require-hashes --only-binary :all: --target "$2" -r "$here/$1"
}

if ! "$here/find.sh" "$folder" > /dev/null 2>&1 && [ -z "${CUDA_PATH:-${CUDA_HOME:-}}" ]; then
    echo "fetching CUDA's compiler and headers (100 MB)"
    install toolkit.txt "$work/toolkit"
    mv "$work/toolkit" "$folder/toolkit"
fi
"$here/find.sh" "$folder" > /dev/null

# The loader's list is no program of everybody's path. (No -q: that would end the pipe.)
known() { PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2> /dev/null | grep "$1" > /dev/null; }
toolkit="$folder/toolkit/nvidia/cu13"
if [ -d "$toolkit" ] && [ ! -e "$toolkit/lib/libcublas.so.13" ]; then
    if [ "${BUNDLE_CUBLAS:-0}" = 1 ] \
        || { known 'libcuda\.so\.1' && ! known 'libcublas\.so\.13'; }; then
        echo "fetching cuBLAS (420 MB)"
        install cublas.txt "$work/cublas"
        cp -r "$work/cublas/nvidia/cu13/." "$toolkit/"
    fi
fi
