#!/bin/sh
# matrix.sh SOURCE FOLDER BUILD...: compares the digests of one run: the same for all, or exit 1. A BUILD is
# gcc-O0, gcc-O3, clang-O0 or clang-O3, made in FOLDER, or a folder that is built already.
set -eu
if [ $# -lt 4 ]; then
    echo "matrix.sh SOURCE FOLDER gcc-O3 clang-O0 [gcc-O0 clang-O3 build/release]" >&2
    exit 2
fi
source=$1 folder=$2
shift 2
mkdir -p "$folder"
first=
failed=0
for build in "$@"; do
    to=$folder/$build
    case $build in
        gcc-O0 | gcc-O3) cc=gcc cxx=g++ ;;
        clang-O0 | clang-O3) cc=clang cxx=clang++ ;;
        *) cc='' to=$build ;;
    esac
    level=-${build#*-}
    log=$folder/$(basename "$build").log
    [ -n "$cc" ] || [ -f "$to/build.ninja" ] || { echo "matrix.sh: $build: no such build" >&2; exit 2; }
    [ -z "$cc" ] || cmake -S "$source" -B "$to" -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_C_COMPILER="$cc" \
        -DCMAKE_CXX_COMPILER="$cxx" -DCMAKE_C_FLAGS="$level" -DCMAKE_CXX_FLAGS="$level" \
        -DPALPATE_VIEW=OFF -DPALPATE_RIG=OFF -DPALPATE_REFERENCE=OFF >"$log" 2>&1 ||
        { cat "$log" >&2; exit 1; }
    ninja -C "$to" palpate-digest >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
    mkdir -p "$to/run"
    digest=$("$to/bin/palpate-digest" "$to/run")
    echo "$build $digest"
    first=${first:-$digest}
    [ "$digest" = "$first" ] || failed=1
done
[ "$failed" = 0 ] || { echo "matrix.sh: the digests differ" >&2; exit 1; }
