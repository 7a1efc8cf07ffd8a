#!/usr/bin/env bash
# tests/vm/run.sh BIN CACHE: the simulated Falcon before a real kernel's USB stack: Debian's kernel under QEMU (no KVM, no
# root), the simulator of BIN on this host, USB/IP between them. Downloads stay below CACHE. Exit 0 when every step in
# the guest passed, 1 when one failed or the guest hung, 2 when something is missing here. For guard.sh, which breaks
# things: PALPATE_VM_INIT, the guest's program; PALPATE_VM_SIM_OPTIONS, of the simulator; PALPATE_VM_GUEST_S, patience.
set -euo pipefail
cd "$(dirname "$0")/../.."
bin=$(realpath "$1")
mkdir -p "$2"
cache=$(realpath "$2")
guest_s=${PALPATE_VM_GUEST_S:-300}  # at most
passed=33                           # QEMU's exit code then, see init.sh
serial=VM000001

say() { printf 'vm: %s\n' "$*" >&2; }
simulator=$bin/palpate-falcon-sim
driver=$bin/palpate-falcon
for program in "$simulator" "$driver"; do
  [ -x "$program" ] || { say "$program is missing; ./dev build makes it"; exit 2; }
done
for program in qemu-system-x86_64 busybox cc dpkg-deb apt-get; do
  command -v "$program" >/dev/null || { say "$program is missing; ./dev vm without --no-install installs it"; exit 2; }
done
usbip=$(PATH=$PATH:/usr/sbin:/sbin command -v usbip) || { say "usbip is missing; install the package usbip"; exit 2; }

kernel=$(tests/vm/kernel.sh "$cache/kernel")
mkdir -p "$cache/bin"
libusb=$(pkg-config --cflags --libs libusb-1.0) || { say "libusb is missing; install libusb-1.0-0-dev"; exit 2; }
for client in tests/sim/usb/clients/plain.c tests/vm/list.c tests/vm/cancel.c; do
  # shellcheck disable=SC2086  # several words
  cc -std=c11 -O2 -o "$cache/bin/$(basename "$client" .c)" "$client" $libusb
done
tests/vm/initramfs.sh "$kernel" "$cache/initramfs.gz" "${PALPATE_VM_INIT:-tests/vm/init.sh}" \
  "$simulator" "$driver" "$usbip" "$cache/bin/plain" "$cache/bin/list" "$cache/bin/cancel"

scratch=$(mktemp -d)
pid=
stop() {
  [ -z "$pid" ] || kill "$pid" 2>/dev/null || true
  rm -rf "$scratch"
}
trap stop EXIT
: > "$scratch/sim.log"
# shellcheck disable=SC2086  # several words
"$simulator" usbip --port 0 --bus "$scratch/bus" --serial $serial ${PALPATE_VM_SIM_OPTIONS:-} > "$scratch/sim.log" 2>&1 &
pid=$!
port=
for _ in $(seq 100); do
  port=$(sed -n 's/.*TCP port \([0-9]*\).*/\1/p' "$scratch/sim.log")
  [ -z "$port" ] && kill -0 "$pid" 2>/dev/null || break
  sleep 0.1
done
[ -n "$port" ] || { say "the simulator did not start:"; cat "$scratch/sim.log" >&2; exit 1; }

code=0
timeout --foreground -k 5 "$guest_s" qemu-system-x86_64 -accel tcg,thread=multi -cpu max -smp 2 -m 512 \
  -nodefaults -nographic -no-reboot -serial stdio -monitor none \
  -netdev user,id=net -device e1000,netdev=net,romfile= -device isa-debug-exit,iobase=0xf4,iosize=0x01 \
  -kernel "$kernel/vmlinuz" -initrd "$cache/initramfs.gz" \
  -append "console=ttyS0 quiet panic=-1 falcon_port=$port falcon_serial=$serial" \
  < /dev/null > "$scratch/console" 2>&1 || code=$?
tr -d '\r' < "$scratch/console" | grep -a '^vm: ' || true
if [ "$code" != "$passed" ]; then
  say "the guest failed: QEMU's exit code is $code; $passed is passed, 124 no end within $guest_s s"
  grep -aq '^vm: FAILED' "$scratch/console" || tail -n 15 "$scratch/console" | tr -d '\r' | sed 's/^/  /' >&2
  exit 1
fi

# The simulator's own view of the same.
status=$("$simulator" status --bus "$scratch/bus") || { say "the simulator has died"; exit 1; }
for piece in '"open":0' '"running":true' '"motor_counts":\[0,0,0\]' '"boots":[4-9]' '"replies":[0-9]{3,}'; do
  grep -qE "$piece" <<< "$status" || { say "the simulator's status lacks $piece: $status"; exit 1; }
done
"$simulator" quit --bus "$scratch/bus" > /dev/null
code=0
wait "$pid" || code=$?
pid=
[ "$code" = 0 ] || { say "the simulator ended with exit code $code:"; cat "$scratch/sim.log" >&2; exit 1; }
say "passed"
