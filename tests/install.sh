#!/bin/sh
# Installs the Debian packages named, if they are missing: `tests/install.sh PACKAGE ...`.
# Says what it installs; says nothing when there is nothing to do.
set -eu
command -v cargo >/dev/null || {
    echo "cargo is missing: install Rust with rustup (https://rustup.rs)" >&2
    exit 1
}
command -v dpkg-query >/dev/null || {
    echo "this is no Debian; make sure that what these packages hold is installed: $*" >&2
    exit 0
}
missing=
for package in "$@"; do
    status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$status" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
echo "installing:$missing"
sudo=
[ "$(id -u)" = 0 ] || sudo=sudo
$sudo apt-get update -qq
# shellcheck disable=SC2086  # a list of packages
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
