#!/usr/bin/env bash
# tests/lint.sh BUILD JOBS: format, forbidden flags, include arrows, clang-tidy. BUILD is configured for clang and has
# compile_commands.json; results of clang-tidy are kept there.
set -euo pipefail
cd "$(dirname "$0")/.."
build=$1
jobs=$2

sources() { git ls-files "$@" -- '*.c' '*.h' '*.cpp' '*.hpp'; }
if ! sources -z | xargs -0 -n 32 -P "$jobs" clang-format --dry-run -Werror --ferror-limit=1; then
  echo "lint: the files above are not formatted; clang-format -i FILE mends them" >&2
  exit 1
fi
echo "lint: format, $(sources | wc -l) files"

# They delete isfinite and change bits.
if git grep -nE -e '-(ffast-math|Ofast|funsafe-math|ffinite-math|fassociative-math)' -- \
    '*.txt' '*.cmake' '*.json' '*.c' '*.cpp' '*.sh' dev; then
  echo "lint: flags above are forbidden" >&2
  exit 1
fi

tests/lint/arrows.sh
tests/lint/tidy.sh "$build" "$jobs"
