#!/usr/bin/env bash
# Includes follow the arrows of docs/DESIGN.md 4. Without arguments: proves on bad files that it sees them, then checks
# the tree. With ROOT: checks the files below it.
set -euo pipefail
cd "$(dirname "$0")/../.."

# Folder: what its files may include of this project. A folder may always include itself; the longest name counts; a
# folder without a line is an error.
arrows='
common           :
firmware/core    : common
firmware/falcon  : firmware/core
firmware/port    : common firmware/core firmware/falcon
firmware/app     : common firmware/core firmware/falcon firmware/port
sim/falcon       :
sim/hand         :
sim/stand        : common firmware/core firmware/falcon sim/falcon sim/hand
sim/usb          : sim/falcon
sim/app          : sim/falcon sim/hand sim/usb
sim/scenes       :
host/cloud       :
host/plate       :
host/plate/reference :
host/contact     : host/cloud
host/chart       : host/cloud host/contact host/plate
host/link        : common
host/scene       : common host/cloud host/contact host/chart host/plate
host/table       : common host/cloud host/contact host/chart host/plate host/scene
host/record      : common
# The force error must not share the road of what it judges: neither host/table nor host/link, nor what reaches them.
host/report      : common host/cloud host/contact host/chart host/plate host/scene host/record
host/latency     : common host/record host/report
host/study       : host/plate host/record host/report host/latency
host/rig         : common
host/view        : host/cloud
host/app         : common sim/stand host
'

# Library headers: the folders (or files) that alone may include them.
leaves='
^(GLFW|epoxy|GL|EGL|GLES.*)/  : host/view
^imgui                        : host/view
^png\.h                       : host/view
^CLI/                         : host/app
^modbus                       : host/rig
^ceres/                       : host/plate/reference
^toml\+\+/                    : host/scene
^nanoflann                    : host/cloud
^nlohmann/                    : host/record host/report host/latency host/study host/app host/plate/reference
^Eigen/                       : host
^getopt\.h                    : firmware/app sim/app
^libusb                       : firmware/port
'

# check ROOT: prints each include against the arrows; fails if there is any.
check() {
  (cd "$1" && find common firmware sim host -name '*.c' -o -name '*.h' -o -name '*.cpp' -o -name '*.hpp' -o -name '*.inc' \
    2>/dev/null | LC_ALL=C sort) > "$list"
  [ -s "$list" ] || { echo "lint: no files below $1, the arrows would hold for anything" >&2; return 1; }
  awk -v root="$1" -v arrows="$arrows" -v leaves="$leaves" '
    function trim(s) { gsub(/^[ \t]+|[ \t]+$/, "", s); return s }
    function folder_of(path) { sub(/\/[^\/]*$/, "", path); return path }
    function below(path, folder) { return path == folder || index(path, folder "/") == 1 }
    function owner(path,   f, best) {
      best = ""
      for (f in may) if (below(path, f) && length(f) > length(best)) best = f
      return best
    }
    function bad(file, n, what) { print file ":" n ": " what; ++n_bad }
    function inner(file, n, name,   from, to, allowed, i, k, ok) {
      from = owner(file); to = owner(name)
      if (from == "") { bad(file, n, "this folder has no arrows (tests/lint/arrows.sh)"); return }
      if (name !~ /^(common|firmware|sim|host)\//) { bad(file, n, name " is not written from the root"); return }
      ok = (from == to)
      k = split(may[from], allowed, " ")
      for (i = 1; i <= k; ++i) if (below(folder_of(name), allowed[i])) ok = 1
      if (!ok) bad(file, n, from " may not include " name)
    }
    function outer(file, n, name,   i, k, where, j, ok) {
      for (i = 1; i <= n_leaves; ++i) if (name ~ leaf[i]) {
        k = split(only[i], where, " "); ok = 0
        for (j = 1; j <= k; ++j) if (below(file, where[j])) ok = 1
        if (!ok) bad(file, n, "<" name "> belongs to " only[i])
      }
    }
    BEGIN {
      k = split(arrows, lines, "\n")
      for (i = 1; i <= k; ++i) if (lines[i] ~ /:/ && lines[i] !~ /^#/) {
        split(lines[i], part, ":"); may[trim(part[1])] = trim(part[2])
      }
      k = split(leaves, lines, "\n")
      for (i = 1; i <= k; ++i) if (lines[i] ~ / : /) {
        at = index(lines[i], " : "); leaf[++n_leaves] = trim(substr(lines[i], 1, at)); only[n_leaves] = trim(substr(lines[i], at + 3))
      }
      while ((getline file < ARGV[1]) > 0) {
        n = 0
        while ((getline line < (root "/" file)) > 0) {
          ++n
          if (line !~ /^[ \t]*#[ \t]*include/) continue
          name = line
          sub(/^[ \t]*#[ \t]*include[ \t]*["<]/, "", name); sub(/[">].*$/, "", name)
          # Whichever the quotes, a name that begins with a folder of ours is ours.
          if (line ~ /"/ || name ~ /^(common|firmware|sim|host|tests)\//) inner(file, n, name); else outer(file, n, name)
        }
        close(root "/" file)
        ++n_files
      }
      if (n_bad > 0) exit 1
      printf "lint: include arrows, %d files\n", n_files
    }' "$list"
}

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
list=$scratch/list

# caught FILE LINE: the check must fail on a tree with just that line in that file.
caught() {
  local tree=$scratch/tree
  rm -rf "$tree" && mkdir -p "$tree/$(dirname "$1")"
  printf '%s\n' "$2" > "$tree/$1"
  if check "$tree" >/dev/null 2>&1; then
    echo "lint: the arrows let '$2' in $1 pass" >&2
    exit 1
  fi
}

if [ $# -gt 0 ]; then
  check "$1"
  exit
fi
caught common/a.c '#include "firmware/core/step.h"'
caught firmware/core/a.c '#include "host/cloud/cloud.hpp"'
caught firmware/core/a.c '#include "firmware/falcon/wire.h"'
caught host/cloud/a.cpp '#  include <firmware/core/step.h>'
caught sim/falcon/a.c '#include "firmware/core/delta.h"'
caught sim/hand/a.c '#include "common/tick.h"'
caught host/plate/a.cpp '#include "host/cloud/cloud.hpp"'
caught host/plate/a.cpp '#include <nlohmann/json.hpp>'
caught host/cloud/a.cpp '#include <epoxy/gl.h>'
caught host/table/a.hpp '#include <CLI/CLI.hpp>'
caught host/report/reference.cpp '#include "host/table/server.hpp"'
caught host/report/a.cpp '#include "host/table/server.hpp"'
caught host/new/a.cpp '#include "common/table.h"'
caught host/cloud/a.cpp '#include "cloud.hpp"'
mkdir "$scratch/none"
if check "$scratch/none" >/dev/null 2>&1; then echo "lint: the arrows hold for no files at all" >&2; exit 1; fi
check .
