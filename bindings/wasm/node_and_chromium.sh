# shellcheck shell=bash
# Node.js with npm, and Chromium unless CHROMIUM or Chrome is there: from Debian, as root, where they are missing. To be sourced.

install() {
    command -v "$1" >/dev/null && return
    apt-get -qq update && apt-get -qq install -y --no-install-recommends "$2"
}
install node nodejs
install npm npm
[ -n "${CHROMIUM-}" ] || command -v google-chrome >/dev/null || install chromium chromium
