#!/usr/bin/env bash
# tests/fuzz/run.sh BUILD SECONDS [TARGET...]: every fuzz target of tests/fuzz/CMakeLists.txt (or those named) for
# SECONDS each, three side by side for every two cores. BUILD is the build folder of the preset `fuzz`, built; what the
# runs make (seeds, corpus, crashes, logs) stays below BUILD/fuzzing, and the next run begins with it.
# Exit 1 when a target crashes, hangs, is not built, or never got behind the checks of its own format.
set -euo pipefail
cd "$(dirname "$0")/../.."
seed=1
timeout_s=10 # for one input; they take microseconds to milliseconds
rss_mb=2048  # under the sanitizers; the inputs are a few KiB

[ $# -ge 2 ] && [[ $2 =~ ^[1-9][0-9]*$ ]] || { echo "usage: tests/fuzz/run.sh BUILD SECONDS [TARGET...]" >&2; exit 2; }
build=$1
seconds=$2
shift 2
work=$build/fuzzing

# Longest input in bytes: a few times the seeds.
declare -A max_len=([array]=2048 [cloud]=2048 [delta_file]=2048 [falcon_feed]=512 [falcon_image]=512 [link]=512 [options]=256 [path]=512 [plate_file]=2048 [record]=4096 [reference]=1024 [rig]=600
  [scene]=8192 [session]=512 [table]=2048 [usb_device]=512 [wire]=256)

mapfile -t targets < <(sed -n 's/^ *pal_fuzz(\([a-z_]*\).*/\1/p' tests/fuzz/CMakeLists.txt)
[ ${#targets[@]} -gt 0 ] || { echo "fuzz: tests/fuzz/CMakeLists.txt defines no target" >&2; exit 1; }
[ $# -eq 0 ] || targets=("$@")
missing=0
for source in tests/fuzz/*_fuzz.cpp; do
  name=$(basename "$source" _fuzz.cpp)
  grep -q "^ *pal_fuzz($name " tests/fuzz/CMakeLists.txt || { echo "fuzz: $source is no target" >&2; missing=1; }
done
for name in "${targets[@]}"; do
  [ -x "$build/bin/fuzz_$name" ] || { echo "fuzz: $build/bin/fuzz_$name is not built" >&2; missing=1; }
  [ -n "${max_len[$name]:-}" ] || { echo "fuzz: $name has no max_len in tests/fuzz/run.sh" >&2; missing=1; }
done
[ -x "$build/bin/pal_fuzz_seeds" ] || { echo "fuzz: $build/bin/pal_fuzz_seeds is not built" >&2; missing=1; }
[ $missing = 0 ] || exit 1

"$build/bin/pal_fuzz_seeds" "$work/seeds"
mkdir -p "$work/corpus" "$work/crashes" "$work/logs"

# What the log of a target says; 1 when it is not good.
verdict() {
  local name=$1 code=$2 log=$work/logs/$1.log done_line input shallow n_inputs
  done_line=$(grep -a '^#[0-9]*[[:space:]]*DONE' "$log" | tail -n 1 || true)
  n_inputs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  if [ "$code" != 0 ] || [ -z "$done_line" ] || [ "${n_inputs:-0}" = 0 ]; then
    input=$(sed -n 's/.*Test unit written to //p' "$log" | tail -n 1)
    printf '%-10s FAILED (exit %s): %s\n' "$name" "$code" "$(grep -a -m 1 -E 'SUMMARY|ERROR:|runtime error' "$log" || tail -n 1 "$log")"
    [ -z "$input" ] || printf '  input      %s\n  reproduce  %s %s\n' "$input" "$build/bin/fuzz_$name" "$input"
    printf '  log        %s\n' "$log"
    return 1
  fi
  # A target whose inputs all end at a magic number or a CRC finds nothing, ever.
  shallow=$(sed -n 's/^reached 0 //p' "$log")
  if [ -n "$shallow" ] || ! grep -q '^reached ' "$log"; then
    printf '%-10s FAILED: no input reached: %s\n' "$name" "$(paste -s -d ',' <<< "${shallow:-anything}")"
    return 1
  fi
  printf '%-10s %9d runs  cov %5d  corpus %5d  %4d s\n' "$name" "$n_inputs" \
    "$(sed 's/.* cov: \([0-9]*\).*/\1/' <<< "$done_line")" "$(sed 's/.* corp: \([0-9]*\).*/\1/' <<< "$done_line")" \
    "$(sed -n 's/^Done [0-9]* runs in \([0-9]*\) second.*/\1/p' "$log")"
}

one() {
  local name=$1 code=0 inputs=("$work/corpus/$1") from options=()
  mkdir -p "$work/corpus/$name" "$work/crashes/$name"
  # Seeds, and what has ever crashed: that is tried first.
  for from in "tests/fuzz/corpus/$name" "$work/seeds/$name" "$work/crashes/$name"; do
    [ -z "$(ls -A "$from" 2>/dev/null)" ] || inputs+=("$from")
  done
  [ ${#inputs[@]} -gt 1 ] || { printf '%-10s FAILED: no seeds\n' "$name"; return 1; }
  [ ! -e "tests/fuzz/dict/$name.dict" ] || options+=("-dict=tests/fuzz/dict/$name.dict")
  # The outer limit is for a target that hangs where libFuzzer cannot see it.
  timeout -k 10 $((seconds + 120)) "$build/bin/fuzz_$name" -seed=$seed -max_total_time="$seconds" \
    -max_len="${max_len[$name]}" -timeout=$timeout_s -rss_limit_mb=$rss_mb -print_final_stats=1 -use_value_profile=1 \
    -artifact_prefix="$work/crashes/$name/" "${options[@]}" "${inputs[@]}" > "$work/logs/$name.log" 2>&1 || code=$?
  verdict "$name" "$code"
}

echo "fuzz: ${#targets[@]} targets, $seconds s each, -seed=$seed"
failed=0
running=0
for name in "${targets[@]}"; do
  if [ $running -ge $(($(nproc) * 3 / 2)) ]; then
    wait -n || failed=1
    running=$((running - 1))
  fi
  one "$name" &
  running=$((running + 1))
done
while [ $running -gt 0 ]; do
  wait -n || failed=1
  running=$((running - 1))
done
exit $failed
