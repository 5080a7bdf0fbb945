#!/usr/bin/env bash
# Thumbnails as desktops ask for them: GNOME's factory, with its own sandbox, and tumbler, which Xfce's file manager calls.
#
# Needs root on Debian: what it calls is installed by apt-get; the package itself lies over /usr for this process alone.
# Usage: packaging/desktop_test.sh PACKAGE.deb
# Pictures are left in target/packages/desktop.
. "$(dirname "$0")/common.sh"
deb=$(realpath "${1:?usage: packaging/desktop_test.sh PACKAGE.deb}")
[ "$(id -u)" = 0 ] || die 'root is needed, to lay the package over /usr'

wanted=(gir1.2-gnomedesktop-4.0 python3-gi tumbler bubblewrap shared-mime-info dbus util-linux)
install_missing "${wanted[@]}"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
pictures=$packages/desktop
rm -rf "$pictures"
mkdir -p "$pictures" "$scratch/home" "$scratch/run"
chmod 700 "$scratch/run"
export SCRATCH=$scratch DEB=$deb PICTURES=$pictures ROOT=$PWD
export HOME=$scratch/home XDG_RUNTIME_DIR=$scratch/run XDG_CACHE_HOME=$scratch/home/.cache
export XDG_DATA_HOME=$scratch/home/.local/share XDG_CONFIG_HOME=$scratch/home/.config

# In a mount name space of its own, so that nothing stays.
# shellcheck disable=SC2016
unshare --mount --propagation private bash -euo pipefail -c '
    mkdir "$SCRATCH/over"
    mount -t tmpfs tmpfs "$SCRATCH/over"
    mkdir "$SCRATCH/over/upper" "$SCRATCH/over/work"
    mount -t overlay overlay -o "lowerdir=/usr,upperdir=$SCRATCH/over/upper,workdir=$SCRATCH/over/work" /usr
    dpkg -x "$DEB" /
    update-mime-database /usr/share/mime
    dbus-run-session -- /usr/bin/python3 "$ROOT/packaging/desktop_callers.py" "$ROOT" "$PICTURES" 2>"$SCRATCH/said" ||
        { cat "$SCRATCH/said" >&2; exit 1; }
    # Where the sandbox can be had at all it can be had within those of the callers, or a thumbnailer would have said so.
    if overcoat --sandbox formats >"$SCRATCH/formats" && grep "not everything is given up" "$SCRATCH/said" >&2; then exit 1; fi
'
