# shellcheck shell=bash
# Sourced by every test of the command line. Arguments: the program, the source tree.
set -uo pipefail

PBNDS=$1
SOURCE=$2
HERE=$SOURCE/tests/tools
failures=0
checks=0

command -v python3 >/dev/null || { echo "python3 is not installed: skipped"; exit 77; }
WORK=$(mktemp -d "${TMPDIR:-$PWD}/cli.XXXXXX")
trap 'rm -rf "$WORK"' EXIT
python3 "$HERE/make_fixtures.py" "$WORK" || exit 1
cd "$WORK" || exit 1

fail() {
    failures=$((failures + 1))
    printf 'FAILED: %s\n' "$*"
    [ -s stderr ] && sed 's/^/    stderr: /' stderr
    return 1
}

# run STATUS COMMAND...: keeps stdout and stderr in files of these names.
run() {
    local want=$1
    shift
    checks=$((checks + 1))
    "$@" >stdout 2>stderr
    local got=$?
    [ "$got" -eq "$want" ] || fail "status $got, not $want: $*"
}

# refuse STATUS PATTERN COMMAND...: that status, and on stderr exactly one sentence, which the
# pattern finds.
refuse() {
    local want=$1 pattern=$2
    shift 2
    run "$want" "$@" || return
    if [ "$(wc -l <stderr)" -ne 1 ]; then
        fail "not one line on stderr: $*"
    elif ! grep -q "^pbnds: " stderr || ! grep -q -e "$pattern" stderr; then
        fail "no '$pattern' on stderr: $*"
    elif [ -s stdout ]; then
        fail "something on stdout: $*"
    fi
}

check() {
    checks=$((checks + 1))
    "$@" || fail "$*"
}

# No temporary file may be left anywhere below the folder.
clean_folder() {
    checks=$((checks + 1))
    local left
    left=$(find "$1" -name '.tmp-*' -o -name '*.tmp*')
    [ -z "$left" ] || fail "left behind: $left"
}

finish() {
    printf '%d checks, %d failures\n' "$checks" "$failures"
    [ "$failures" -eq 0 ] && [ "$checks" -gt 0 ]
    exit
}
