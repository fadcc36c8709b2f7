#!/usr/bin/env bash
# docs.rs can build the documentation of the library: with DOCS_RS set, no native library is
# looked for. Here pkg-config and libclang are out of reach, as there.
set -euo pipefail
cd "$(dirname "$0")/.."

export CARGO_TARGET_DIR=target/docs-rs PKG_CONFIG=/nonexistent LIBCLANG_PATH=/nonexistent
if cargo check --locked -p cholmod-sys 2>/dev/null; then
    echo "cholmod-sys was built without libclang: this test hides nothing" >&2
    exit 1
fi
DOCS_RS=1 RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps -p cholmod-sys -p cgal-sys -p dempfv
if [ -n "$(find "$CARGO_TARGET_DIR" -name '*dempfv_cgal_shim*')" ]; then
    echo "cgal-sys has compiled against CGAL, which docs.rs has not" >&2
    exit 1
fi
rm -rf "$CARGO_TARGET_DIR"
