#!/bin/sh
# digest_matrix.sh SOURCE FOLDER COMPILER-LEVEL...: builds palpate-digest in FOLDER/COMPILER-LEVEL for each of gcc-O0
# gcc-O3 clang-O0 clang-O3, and compares the digests of one run: the same for all, or exit 1.
set -eu
if [ $# -lt 3 ]; then
    echo "digest_matrix.sh SOURCE FOLDER gcc-O3 clang-O0 [gcc-O0 clang-O3]" >&2
    exit 2
fi
source=$1 folder=$2
shift 2
mkdir -p "$folder"
first=
failed=0
for build in "$@"; do
    compiler=${build%-*} level=-${build#*-}
    case $compiler in
        gcc) cc=gcc cxx=g++ ;;
        clang) cc=clang cxx=clang++ ;;
        *) echo "digest_matrix.sh: $build: gcc or clang, then -O0 or -O3" >&2; exit 2 ;;
    esac
    command -v "$cxx" >/dev/null || { echo "digest_matrix.sh: $cxx is not installed" >&2; exit 2; }
    to=$folder/$build
    cmake -S "$source" -B "$to" -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_C_COMPILER="$cc" \
        -DCMAKE_CXX_COMPILER="$cxx" -DCMAKE_C_FLAGS="$level" -DCMAKE_CXX_FLAGS="$level" \
        -DPALPATE_VIEW=OFF -DPALPATE_RIG=OFF -DPALPATE_REFERENCE=OFF >"$to.log" 2>&1 ||
        { cat "$to.log" >&2; exit 1; }
    ninja -C "$to" palpate-digest >"$to.log" 2>&1 || { cat "$to.log" >&2; exit 1; }
    mkdir -p "$to/run"
    digest=$("$to/bin/palpate-digest" "$to/run")
    echo "$build $digest"
    first=${first:-$digest}
    [ "$digest" = "$first" ] || failed=1
done
[ "$failed" = 0 ] || { echo "digest_matrix.sh: the digests differ" >&2; exit 1; }
