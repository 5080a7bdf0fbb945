#!/usr/bin/env bash
# The work of action.yml: renders, compares, and leaves report and summary. Its inputs are in the environment, so that nothing of them
# is taken for a command but what is one.
set -euo pipefail
: "${RENDER=}" "${EXPECTED:?no folder of expected pictures}" "${ACTUAL:?no folder of actual pictures}"
: "${THRESHOLDS=}" "${REPORT:=golden-report}" "${ARGUMENTS=}" "${INSTALL:=true}" "${ACTION:?}"
: "${RUNNER_TEMP:=${TMPDIR:-/tmp}}" "${GITHUB_OUTPUT:=/dev/null}" "${GITHUB_STEP_SUMMARY:=/dev/null}"

case $REPORT in
    '' | *[!A-Za-z0-9._-]*) echo "report: '$REPORT' is no name of letters, digits, dots, dashes and underscores" >&2; exit 2 ;;
esac
if ! command -v overcoat >/dev/null; then
    [ "$INSTALL" = true ] || { echo 'overcoat is not on the path, and install is not true' >&2; exit 2; }
    cargo install --locked --path "$ACTION/crates/cli"
    export PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
fi
if [ -n "$RENDER" ]; then
    bash -euo pipefail -c "$RENDER"
fi

arguments=()
[ -z "$THRESHOLDS" ] || arguments+=(--thresholds "$THRESHOLDS")
# Words, as in a shell's command line without quotes.
read -ra more <<<"$ARGUMENTS"
page=$RUNNER_TEMP/$REPORT.html
status=0
overcoat golden report "$EXPECTED" "$ACTUAL" -o "$page" "${arguments[@]}" "${more[@]}" | tee "$RUNNER_TEMP/$REPORT.txt" || status=$?

differs=false
[ "$status" != 4 ] || differs=true
echo "differs=$differs" >>"$GITHUB_OUTPUT"
{
    printf '### Golden pictures\n\n'
    if [ "$status" = 0 ]; then printf 'All are as expected.\n'; else printf 'Some are not as expected: artifact `%s`.\n' "$REPORT"; fi
    printf '\n```\n'
    cat "$RUNNER_TEMP/$REPORT.txt"
    printf '```\n'
} >>"$GITHUB_STEP_SUMMARY"
exit "$status"
