# shellcheck shell=bash
# What the scripts of this folder have in common; they source it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export CARGO_TERM_COLOR=never LC_ALL=C TZ=UTC
umask 022

# shellcheck disable=SC2034
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
# Where packages go.
packages=${OVERCOAT_PACKAGES:-$PWD/target/packages}
mkdir -p "$packages"

# Times in packages: of the last commit, unless somebody says otherwise.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CHANGELOG.md)}
export SOURCE_DATE_EPOCH

die() {
    printf '%s: %s\n' "$(basename "$0")" "$*" >&2
    exit 1
}

# need COMMAND PACKAGE: says what to install, in Debian's words.
need() {
    command -v "$1" >/dev/null || die "there is no $1: apt-get install $2"
}

# install_missing PACKAGE...: what a test needs of Debian.
install_missing() {
    need dpkg-query dpkg
    local name
    local -a lacking=()
    for name in "$@"; do
        dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null | grep -qx installed || lacking+=("$name")
    done
    [ ${#lacking[@]} -gt 0 ] || return 0
    [ "$(id -u)" = 0 ] || die "as root: apt-get install ${lacking[*]}"
    apt-get -qq update
    DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends install "${lacking[@]}" >/dev/null ||
        die "apt-get cannot install all of: ${lacking[*]}"
}

# package_of PROGRAM: the package that has it.
package_of() { [ "$1" = overcoat ] && echo overcoat-cli || echo "$1"; }

# binary_variable PROGRAM [STATIC_]: the variable that names a program to take in place of building it, as OVERCOAT_SERVICE_BINARY.
binary_variable() {
    local name=${1^^}
    printf '%s_%sBINARY' "${name//-/_}" "${2-}"
}
