#!/usr/bin/env bash
# tests/bench/wakeup_pairs.sh [--pairs N] [--seconds N] [--cpu CPU] [--priority P] [--device WHAT] [--bin DIR]
# Wake-up of palpate-loop beside cyclictest's (package rt-tests), in pairs that follow each other at once and change
# places from pair to pair: what disturbs the machine for minutes disturbs both. Prints every pair, the ratios ours /
# theirs of p50 and p99, and their median with a 95 % interval from the ranks (sign test: no assumption on how they
# spread). Both are compared as cyclictest counts: one sample for each start, whole us. Needs cyclictest and jq, and
# root or the right to SCHED_FIFO and locked memory. The loop runs on a simulated Falcon, or on --device usb.
# CYCLICTEST and PALPATE in the environment name other programs.
set -euo pipefail

pairs=10 seconds=20 cpu=1 priority=80 device=sim bin=
while [ $# -gt 0 ]; do
  case $1 in
    --pairs) pairs=$2 ;;
    --seconds) seconds=$2 ;;
    --cpu) cpu=$2 ;;
    --priority) priority=$2 ;;
    --device) device=$2 ;;
    --bin) bin=$2 ;;
    *) echo "wakeup_pairs.sh: unknown option $1" >&2; exit 2 ;;
  esac
  [ $# -ge 2 ] || { echo "wakeup_pairs.sh: $1 needs a value" >&2; exit 2; }
  shift 2
done
for number in "$pairs" "$seconds" "$cpu" "$priority"; do
  [[ $number =~ ^[0-9]+$ ]] || { echo "wakeup_pairs.sh: $number is not a whole number" >&2; exit 2; }
done
[ "$pairs" -ge 1 ] && [ "$seconds" -ge 1 ] || { echo "wakeup_pairs.sh: one pair of one second at least" >&2; exit 2; }
cyclictest=${CYCLICTEST:-cyclictest} palpate=${PALPATE:-${bin:+$bin/}palpate}
for program in "$cyclictest" "$palpate" jq; do
  command -v "$program" >/dev/null || { echo "wakeup_pairs.sh: $program is not there" >&2; exit 2; }
done
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

steal() { awk '$1 == "cpu" { print $9; exit }' /proc/stat; }

# Histogram on stdin: "p50 p99 p99.9 max n", in us, by nearest rank. A rank beyond the histogram is the maximum.
percentiles() {
  awk '
    /^# Max Latencies:/ { max = $4 + 0 }
    /^# Histogram Overflows:/ { over = $4 + 0 }
    /^[0-9]+[ \t]+[0-9]+/ { value[k] = $1 + 0; count[k++] = $2; n += $2 }
    function at(share,    rank, i, sum) {
      rank = int(share * n / 10000); if (rank * 10000 < share * n) rank++
      for (i = 0; i < k; i++) { sum += count[i]; if (sum >= rank) return value[i] }
      return max
    }
    END { n += over; if (n == 0) exit 1; print at(5000), at(9900), at(9990), max, n }'
}

theirs() {
  timeout $((seconds + 30)) "$cyclictest" -m "-p$priority" -i1000 -t1 -a "$cpu" -q -D "$seconds" -h 2000 \
    >"$scratch/theirs" 2>"$scratch/errors" || { cat "$scratch/errors" >&2; exit 3; }
  percentiles <"$scratch/theirs" || { echo "wakeup_pairs.sh: cyclictest printed no histogram" >&2; exit 3; }
}

# Exit code 1 is a verdict, and the figures are there.
ours() {
  local code=0
  timeout $((seconds + 30)) "$palpate" device latency --device "$device" --seconds "$seconds" --cpu "$cpu" \
    --policy fifo --priority "$priority" --json >"$scratch/ours" 2>"$scratch/errors" || code=$?
  [ "$code" -le 1 ] || { cat "$scratch/errors" >&2; exit 3; }
  jq -er '.wake_up_raw | select(.known) | [(.p50_us, .p99_us, .p99_9_us | floor), .max_us, .n] | join(" ")' \
    "$scratch/ours" ||
    { echo "wakeup_pairs.sh: palpate device latency does not know its wake-up" >&2; exit 3; }
}

printf '%-5s %-11s %9s %9s %9s %9s %9s %7s\n' pair us p50 p99 p99.9 max n steal
for ((pair = 1; pair <= pairs; pair++)); do
  order=(theirs ours)
  ((pair % 2)) || order=(ours theirs)
  for who in "${order[@]}"; do
    before=$(steal)
    figures=$("$who")
    stolen=$(($(steal) - before))
    echo "$figures" >"$scratch/$who.figures"
    read -r p50 p99 p999 max n <<<"$figures"
    name=cyclictest
    [ "$who" = theirs ] || name=palpate
    printf '%-5s %-11s %9.1f %9.1f %9.1f %9.1f %9d %7d\n' "$pair" "$name" "$p50" "$p99" "$p999" "$max" "$n" "$stolen"
    echo "$stolen" >>"$scratch/steal"
  done
  paste -d' ' "$scratch/ours.figures" "$scratch/theirs.figures" |
    awk '{ if ($6 > 0 && $7 > 0) print $1 / $6, $2 / $7 }' >>"$scratch/ratios"
  awk -v pair="$pair" 'END { printf "%-5s %-11s %9.2f %9.2f\n", pair, "ratio", $1, $2 }' "$scratch/ratios"
done

# Ratios on stdin: their median, and the closest ranks that a sign test at 5 % leaves out on both sides.
median() {
  sort -g | awk -v what="$1" '
    { x[++n] = $1 }
    END {
      middle = n % 2 ? x[(n + 1) / 2] : (x[n / 2] + x[n / 2 + 1]) / 2
      p = 0.5 ^ n; sum = 0; k = 0
      while (k < n && sum + p <= 0.025) { sum += p; p *= (n - k) / (k + 1); k++ }
      printf "%s: median ratio palpate / cyclictest %.2f", what, middle
      if (k >= 1) printf ", 95 %% interval %.2f to %.2f (%.1f %%, %d pairs)\n", x[k], x[n + 1 - k],
                          100 * (1 - 2 * sum), n
      else printf "; %d pairs are too few for a 95 %% interval, 6 have one\n", n
    }'
}
cut -d' ' -f1 "$scratch/ratios" | median p50
cut -d' ' -f2 "$scratch/ratios" | median p99
awk '{ sum += $1; if ($1 > 0) n++ } END {
  printf "stolen by the hypervisor: %d ticks of 10 ms in %d of %d runs", sum, n, NR
  print (sum > 0 ? ": not valid for latency; the ratios compare, the figures do not hold" : "") }' "$scratch/steal"
