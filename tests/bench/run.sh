#!/usr/bin/env bash
# tests/bench/run.sh BIN [--benchmark_...]: tables to read on the screen, every repetition of everything in
# out/bench.json. Repetitions of the benchmarks are mixed, so that a busy minute of the machine meets all alike.
set -euo pipefail
cd "$(dirname "$0")/../.."
bin=$1
shift
mkdir -p out
commit=$(git describe --always --dirty --abbrev=12 2>/dev/null || echo unknown)
"$bin/palpate-bench" "$commit" --benchmark_enable_random_interleaving=true \
  --benchmark_out=out/bench.json.part --benchmark_out_format=json "$@"
mv out/bench.json.part out/bench.json
if [ $# = 0 ]; then
  echo
  echo "**Wake-up of palpate-loop beside cyclictest's**"
  tests/bench/wakeup_pairs.sh --pairs 4 --seconds 10 --bin "$bin"
fi
echo
echo "every repetition: out/bench.json"
