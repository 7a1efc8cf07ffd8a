#!/usr/bin/env bash
# tests/lint.sh BUILD JOBS: format, forbidden flags, include arrows, clang-tidy. BUILD is configured for clang and has
# compile_commands.json; results of clang-tidy are kept there.
set -euo pipefail
cd "$(dirname "$0")/.."
build=$1
jobs=$2

git ls-files -z -- '*.c' '*.h' '*.cpp' '*.hpp' | xargs -0 -n 32 -P "$jobs" clang-format --dry-run -Werror
echo "lint: format, $(git ls-files -- '*.c' '*.h' '*.cpp' '*.hpp' | wc -l) files"

# They delete isfinite and change bits.
if git grep -nE -e '-(ffast-math|Ofast|funsafe-math|ffinite-math|fassociative-math)' -- \
    '*.txt' '*.cmake' '*.json' '*.c' '*.cpp' '*.sh' dev; then
  echo "lint: flags above are forbidden" >&2
  exit 1
fi

tests/lint/arrows.sh
tests/lint/tidy.sh "$build" "$jobs"
