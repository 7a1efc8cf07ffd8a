#!/usr/bin/env bash
# tests/lint/tidy.sh BUILD JOBS: clang-tidy on every C and C++ file of the product, in the units in which BUILD compiles
# them (PALPATE_UNITY: a dozen in one). A unit is looked at again when one of its files, a header of the project that
# they reach, its compile command, .clang-tidy or clang-tidy itself has changed.
# The tests' own files are held to warnings only: Catch's macros would triple the time.
set -euo pipefail
cd "$(dirname "$0")/../.."
build=$1
jobs=$2
cache=$build/tidy
mkdir -p "$cache"

# A name in .clang-tidy that means nothing must not pass as a clean run.
known=$(clang-tidy --checks='*' --list-checks | sed -n 's/^ \+//p')
wanted=$(sed -n '/^Checks:/,/^[A-Z].*:/{/^ /p}' .clang-tidy | tr -d ' ,' | grep -v '^-\*$')
[ -n "$wanted" ] || { echo "lint: no checks in .clang-tidy" >&2; exit 1; }
unknown=$(comm -13 <(LC_ALL=C sort <<< "$known") <(LC_ALL=C sort <<< "$wanted"))
[ -z "$unknown" ] || { echo "lint: .clang-tidy names checks that do not exist:" $unknown >&2; exit 1; }

# A finding must fail, also in a header of ours.
mkdir -p "$cache/self/host"
printf '%s\n' '#include <string>' '#include <utility>' 'inline unsigned long used(std::string s) {' \
  '    const std::string t = std::move(s);' '    return t.size() + s.size();' '}' > "$cache/self/host/bad.hpp"
printf '%s\n' '#include "host/bad.hpp"' 'int main() { return static_cast<int>(used("a")); }' > "$cache/self/bad.cpp"
if clang-tidy --quiet --config-file=.clang-tidy "$cache/self/bad.cpp" -- -std=c++20 -I "$cache/self" \
    > "$cache/self/out" 2>&1 || ! grep -q bugprone-use-after-move "$cache/self/out"; then
  echo "lint: clang-tidy let a known mistake pass" >&2
  cat "$cache/self/out" >&2
  exit 1
fi

# UNIT KEY: key = hash of all that a finding can depend on.
tools=$(clang-tidy --version | tr -d '\n'; cat .clang-tidy)
git ls-files -- 'common/*.c' 'firmware/*.c' 'sim/*.c' 'host/*.cpp' > "$cache/files"
[ -s "$cache/files" ] || { echo "lint: no files" >&2; exit 1; }
awk -v root="$PWD/" '
  /"command":/ { command = $0 }
  /"file":/ { file = $0; sub(/.*"file": "/, "", file); sub(/".*/, "", file)
              if (index(file, root) == 1) print substr(file, length(root) + 1) "\t" command }
' "$build/compile_commands.json" | LC_ALL=C sort -u -t "$(printf '\t')" -k 1,1 > "$cache/commands"
# UNIT FILE...: what each compiles of the files above; a file that is in two is looked at in one.
awk -v root="$PWD/" '
  NR == FNR { is_wanted[$1]; next }
  { sub(/\t.*/, ""); unit = $0; files = ""; n = 0
    if (unit ~ /\/Unity\//) {
      while ((getline line < unit) > 0) if (line ~ /^#include "/) {
        sub(/^#include "/, "", line); sub(/".*/, "", line)
        if (index(line, root) == 1) file[++n] = substr(line, length(root) + 1)
      }
      close(unit)
    } else file[++n] = unit
    for (i = 1; i <= n; ++i)
      if (file[i] in is_wanted && !(file[i] in is_taken)) { is_taken[file[i]]; files = files " " file[i] }
    if (files != "") print unit files }
' "$cache/files" <(grep '/Unity/.*	' "$cache/commands"; cat "$cache/commands") > "$cache/units"
missing=$(comm -23 <(LC_ALL=C sort "$cache/files") <(cut -d ' ' -f 2- "$cache/units" | tr ' ' '\n' | LC_ALL=C sort))
[ -z "$missing" ] || { echo "lint: in no target, so never compiled:" $missing >&2; exit 1; }
# UNIT FILE...: with the project headers that its files reach; includes are written from the root.
awk '
  function scan(file,   line, name) {
    if (file in includes) return
    includes[file] = ""
    while ((getline line < file) > 0) if (line ~ /^[ \t]*#[ \t]*include[ \t]*"/) {
      name = line; sub(/^[^"]*"/, "", name); sub(/".*/, "", name)
      includes[file] = includes[file] " " name
    }
    close(file)
  }
  { n = 0; delete seen; for (i = 2; i <= NF; ++i) { queue[++n] = $i; seen[$i] = 1 }
    for (i = 1; i <= n; ++i) {
      scan(queue[i]); k = split(includes[queue[i]], next_, " ")
      for (j = 1; j <= k; ++j) if (!(next_[j] in seen)) { seen[next_[j]] = 1; queue[++n] = next_[j] }
    }
    printf "%s", $1; for (i = 1; i <= n; ++i) printf " %s", queue[i]; print ""
  }' "$cache/units" > "$cache/reach"
# (A generated header is not there to be read; what it is generated from is in the tree and changes seldom.)
while read -r unit reached; do
  key=$( { printf '%s\n' "$tools"; grep -F "$unit	" "$cache/commands"; cat "$unit" $reached 2>/dev/null || true; } | sha256sum)
  printf '%s %s\n' "$unit" "${key%% *}"
done < "$cache/reach" > "$cache/keys"

one() {
  local unit=$1 mark=$2/$3.ok
  [ -e "$mark" ] && return 0
  # stderr counts warnings in headers that nobody asked about.
  clang-tidy --quiet -p "$4" "$unit" 2>"$2/$3.err" || { cat "$2/$3.err" >&2; return 1; }
  rm -f "$2/$3.err" && touch "$mark"
}
export -f one
find "$cache" -name '*.ok' -mtime +30 -delete
fresh=$(while read -r _ key; do [ -e "$cache/$key.ok" ] || echo; done < "$cache/keys" | wc -l)
xargs -P "$jobs" -L 1 bash -c 'one "$2" "$0" "$3" "$1"' "$cache" "$build" < "$cache/keys"
echo "lint: clang-tidy, $(wc -l < "$cache/files") files in $(wc -l < "$cache/units") units ($fresh looked at, the rest unchanged)"
