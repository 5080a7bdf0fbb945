#!/usr/bin/env bash
# The service under a real systemd: installs its Debian package in a container, boots that, and tries the unit.
#
# Needs root on Debian, for apt-get and systemd-nspawn, and a network for debootstrap; the container has none.
# Usage: packaging/systemd_test.sh OVERCOAT.deb OVERCOAT_SERVICE.deb
# OVERCOAT_SYSTEMD_ROOT, if set: the root of a Debian with systemd, of which a copy is taken in place of making one.
[ $# = 2 ] || { sed -n 's/^# Usage: /usage: /p' "$0" >&2; exit 2; }
packages_tried=("$(realpath "$1")" "$(realpath "$2")")
. "$(dirname "$0")/common.sh"
install_missing systemd-container debootstrap curl

work=$(mktemp -d)
root=$work/root
finish() {
    [ -z "${nspawn-}" ] || { kill "$nspawn" 2>/dev/null && wait "$nspawn"; } || true
    rm -rf --one-file-system "$work"
}
trap finish EXIT
step() { printf '== %s\n' "$*"; }

if [ -n "${OVERCOAT_SYSTEMD_ROOT-}" ]; then
    cp -a "$OVERCOAT_SYSTEMD_ROOT" "$root"
else
    debootstrap --variant=minbase --include=systemd,systemd-sysv,dbus,ca-certificates,procps bookworm "$root" >"$work/debootstrap.log" ||
        die "$(tail -3 "$work/debootstrap.log")"
fi
mkdir -p "$root/packages"
cp "${packages_tried[@]}" "$root/packages/"

# Where there is no systemd outside, there is none to be asked for a scope. The calls by which workers give up their rights are not among
# those that nspawn allows.
systemd-nspawn --quiet -D "$root" --boot --register=no --keep-unit --private-network --console=pipe \
    --system-call-filter='landlock_create_ruleset landlock_add_rule landlock_restrict_self' >"$work/console" 2>&1 </dev/null &
nspawn=$!
# within COMMAND...: in the container.
within() { nsenter -a -t "$leader" "$@"; }
# asked CURL_OPTION...: over the container's loopback.
asked() { nsenter -n -t "$leader" curl -sS --max-time 60 "$@"; }
# until_so COMMAND...: at most half a minute.
until_so() {
    local k
    for k in $(seq 150); do
        "$@" >/dev/null 2>&1 && return 0
        sleep 0.2
    done
    within journalctl -u overcoat --no-pager | tail -20 >&2 || tail -20 "$work/console" >&2
    die "never so: $*"
}
has_leader() { leader=$(pgrep -P "$nspawn" -x systemd); }
until_so has_leader
is_up() { within systemctl is-system-running | grep -qxE 'running|degraded'; }
until_so is_up
is_ready() { test "$(asked -o /dev/null -w '%{http_code}' http://127.0.0.1:8080/ready)" = 200; }
property() { within systemctl show overcoat -P "$1"; }

step "$(within systemctl --version | head -1), $(uname -r)"
within dpkg -i "${packages_tried[@]/#*\//\/packages\/}" >"$work/dpkg" 2>&1 || die "$(cat "$work/dpkg")"
test "$(within systemctl is-enabled overcoat || true)" = disabled || die 'the package enables its unit'
within systemctl enable --now overcoat 2>/dev/null
until_so is_ready

step 'it draws what the program draws'
asked --data-binary @assets/models/sports-car.glb 'http://127.0.0.1:8080/render?size=100' -o "$work/served.png"
within overcoat render - -o - --size 100 <assets/models/sports-car.glb >"$work/usual.png"
cmp "$work/served.png" "$work/usual.png"
said=$(within journalctl -u overcoat -p warning --no-pager -q -o cat)
test -z "$said" || die "it warns: $said"

step 'its workers have no rights, and its files are its own'
main=$(property MainPID)
workers=$(within pgrep -P "$main")
for worker in $workers; do
    within grep -qx 'Seccomp:	2' "/proc/$worker/status" || die "worker $worker has no filter of system calls"
    within grep -qx 'NoNewPrivs:	1' "/proc/$worker/status" || die "worker $worker may gain rights"
done
test "$(within stat -c %a /var/cache/private/overcoat)" = 700 || die 'others may read the cache'
test -n "$(within find /var/cache/private/overcoat -type f)" || die 'nothing is in the cache'

step 'kill -9: it is started anew, and no worker stays'
before=$(within pgrep -cf 'overcoat-service')
within kill -9 "$main"
is_another() { test "$(property MainPID)" != "$main" && is_ready; }
until_so is_another
test "$(property NRestarts)" = 1 || die "$(property NRestarts) restarts"
same_number() { test "$(within pgrep -cf 'overcoat-service')" -le "$before"; }
until_so same_number

step 'SIGTERM: what was begun is finished'
asked --data-binary @assets/models/sports-car.glb 'http://127.0.0.1:8080/render?size=700' -o "$work/last.png" -w '%{http_code}' \
    >"$work/last" &
last=$!
is_busy() { asked http://127.0.0.1:8080/metrics | grep -qx 'overcoat_workers_busy 1'; }
until_so is_busy
within systemctl stop overcoat
wait "$last"
test "$(cat "$work/last")" = 200 || die "$(cat "$work/last")"
test "$(property Result) $(property ExecMainStatus) $(property ActiveState)" = 'success 0 inactive' || die "$(within systemctl status overcoat)"
test "$(within pgrep -cf overcoat-service || true)" = 0 || die 'something is left'

step 'a socket for the group of a web server'
within mkdir -p /etc/systemd/system/overcoat.service.d
within tee /etc/systemd/system/overcoat.service.d/socket.conf >/dev/null <service/overcoat-socket.conf
within systemctl daemon-reload
within systemctl start overcoat
is_reached() { within runuser -u www-data -- test -S /run/overcoat/overcoat.sock; }
until_so is_reached
test "$(within stat -c '%a %G' /run/overcoat/overcoat.sock)" = '660 www-data' || die "$(within stat -c '%a %U %G' /run/overcoat/overcoat.sock)"
within runuser -u nobody -- test -e /run/overcoat/overcoat.sock && die 'others reach the socket'
within systemctl stop overcoat

step 'settings, and keys that nobody sees'
within rm -r /etc/systemd/system/overcoat.service.d
within systemctl daemon-reload
printf 'OVERCOAT_LISTEN=127.0.0.1:8090\nOVERCOAT_CONFIG=/etc/overcoat-service.toml\n' | within tee /etc/default/overcoat-service >/dev/null
within cp /usr/share/doc/overcoat-service/examples/example.toml /etc/overcoat-service.toml
within systemctl start overcoat
is_elsewhere() { asked --fail http://127.0.0.1:8090/ready; }
until_so is_elsewhere
asked http://127.0.0.1:8090/formats | grep -q '"presets":\["thumb"\]' || die 'the configuration is not read'

step 'systemd-analyze security'
within systemd-analyze security overcoat --no-pager | tail -1

step 'purge'
within dpkg --purge overcoat-service >"$work/dpkg" 2>&1 || die "$(cat "$work/dpkg")"
test "$(within pgrep -cf overcoat-service || true)" = 0 || die 'it still runs'
if within test -e /var/cache/private/overcoat; then die 'its cache is still there'; fi
