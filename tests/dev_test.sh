#!/usr/bin/env bash
# ./dev on a machine that lacks everything: stand-ins for dpkg-query, apt-get, id and sudo say so, and nothing is
# installed. Exit 1 and a line for each thing that is not as ./dev help promises.
set -uo pipefail
cd "$(dirname "$0")/.."
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
failed=0

# command_of NAME TEXT: a stand-in that runs TEXT.
command_of() {
  printf '#!/bin/sh\n%s\n' "$2" > "$scratch/bin/$1"
  chmod +x "$scratch/bin/$1"
}
mkdir "$scratch/bin"
command_of dpkg-query 'exit 1'
command_of apt-get "echo \"\$@\" >> '$scratch/installed'; exit 100"
command_of sudo "echo \"\$@\" >> '$scratch/installed'; exit 100"
command_of id 'echo 1000'

# expect WHAT CODE PATTERN COMMAND...: exit code and words (stdout and stderr together).
expect() {
  local what=$1 code=$2 pattern=$3 words status=0
  shift 3
  words=$("$@" 2>&1) || status=$?
  if [ "$status" != "$code" ] || ! grep -qE "$pattern" <<< "$words"; then
    echo "dev: $what: exit $status (expected $code), and said: $words" >&2
    failed=1
  fi
}

lacking() { PATH="$scratch/bin:$PATH" "$@"; }
for command in build demo test lint asan tsan vm bench soak; do
  expect "$command --no-install" 2 'missing packages.*' lacking ./dev "$command" --no-install
  expect "$command --no-install lists what is missing" 2 '^  .*libeigen3-dev' lacking ./dev "$command" --no-install
done
[ ! -e "$scratch/installed" ] || { echo "dev: --no-install installed something" >&2; failed=1; }
expect "a failed installation lists what is missing" 2 'missing packages: .*libeigen3-dev' lacking ./dev build
expect "it says what it installs" 2 'installing from the distribution: .*cmake' lacking ./dev build
rm "$scratch/bin/sudo"
if ! PATH="$scratch/bin:$PATH" command -v sudo >/dev/null; then
  expect "neither root nor sudo" 2 'neither root nor sudo' lacking ./dev build
fi
for command in build demo test lint asan tsan vm bench soak clean; do
  expect "help names $command" 0 "^\./dev $command " ./dev help
done
# The README names commands that exist and scenes that are there.
named=$(grep -oE '\./dev [a-z]+' README.md | sort -u)
[ -n "$named" ] || { echo "dev: README.md names no ./dev command" >&2; failed=1; }
while read -r _ command; do
  [ "$command" = help ] || expect "README's $command" 0 "^\./dev $command " ./dev help
done <<< "$named"
while read -r file; do
  [ -e "$file" ] || { echo "dev: README.md names $file, which is not there" >&2; failed=1; }
done < <(grep -oE '\b(sim|docs|tests|host)/[a-zA-Z_./]+\.(toml|md|cpp|png)' README.md | sort -u)
expect "an unknown command" 2 'unknown command sing' ./dev sing
expect "an unknown option" 2 'unknown option --loud' ./dev build --loud
exit "$failed"
