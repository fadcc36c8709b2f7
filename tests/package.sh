#!/usr/bin/env bash
# Packs the crates and builds each from its own package, as `cargo publish` would.
#
# Cargo unpacks the crates of the workspace under the cargo home, in a folder named after the place
# of the checkout, and takes what lies there for good while the version stays the same: a later
# checkout in the same place would be built against the sources of the earlier one. So this runs
# with a cargo home of its own, which borrows all but the unpacked sources.
set -euo pipefail
cd "$(dirname "$0")/.."

lender="${CARGO_HOME:-$HOME/.cargo}"
home="$(mktemp -d)"
trap 'rm -rf "$home"' EXIT

mkdir -p "$lender/registry/cache" "$lender/registry/index" "$home/registry"
for part in "$lender"/* "$lender"/registry/cache "$lender"/registry/index; do
    [ "$part" = "$lender/registry" ] || ln -s "$part" "$home${part#"$lender"}"
done

# All but the Python package, which goes out as a wheel.
CARGO_HOME="$home" cargo package --workspace --exclude dempfv-python --locked --allow-dirty
