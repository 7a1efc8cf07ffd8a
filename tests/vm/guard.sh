#!/usr/bin/env bash
# tests/vm/guard.sh BIN CACHE: run.sh must fail, with its reason, when the device, the guest or the host is broken.
set -euo pipefail
cd "$(dirname "$0")/../.."
bin=$1
cache=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# caught WHAT CODE PATTERN [VARIABLE=VALUE...]: run.sh with these must end with CODE and say PATTERN.
caught() {
  local what=$1 code=$2 pattern=$3 status=0
  shift 3
  env "$@" tests/vm/run.sh "$bin" "$cache" > "$scratch/words" 2>&1 || status=$?
  if [ "$status" != "$code" ] || ! grep -qE "$pattern" "$scratch/words"; then
    echo "vm: not caught: $what: exit $status (expected $code), and said:" >&2
    cat "$scratch/words" >&2
    exit 1
  fi
  echo "vm: caught: $what"
}

# init TEXT...: a guest that does only this.
init() { printf '%s\n' '#!/bin/busybox sh' "$@" > "$scratch/init.sh"; }

echo 'boot-fail stage=5 byte=7 n=1000' > "$scratch/faults"
caught "a device that does not boot" 1 'FAILED: booted, 300 exchanges' PALPATE_VM_SIM_OPTIONS="--faults $scratch/faults"
init 'echo vm: passed 99' 'exit 0'
caught "a guest that ends by a kernel panic" 1 "QEMU's exit code is" PALPATE_VM_INIT="$scratch/init.sh"
init 'echo vm: passed 99' '/bin/busybox sleep 1000'
caught "a guest that hangs" 1 "exit code is 124" PALPATE_VM_INIT="$scratch/init.sh" PALPATE_VM_GUEST_S=10
init '/bin/busybox mount -t devtmpfs dev /dev' '/bin/busybox printf "\020" > /tmp/16' \
  '/bin/busybox dd if=/tmp/16 of=/dev/port bs=1 seek=244'
caught "a guest that says passed and did nothing" 1 "simulator's status lacks" PALPATE_VM_INIT="$scratch/init.sh"
bin=$scratch/nowhere
mkdir "$bin"
caught "no simulator" 2 'palpate-falcon-sim is missing'
