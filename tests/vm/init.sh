#!/bin/busybox sh
# The guest: Debian's own USB stack meets the simulated Falcon over USB/IP, once from the host over the network, once
# from a simulator in here. Steps in order, the first that fails ends it. QEMU exits with 33 when all passed.
/bin/busybox --install -s /bin
export PATH=/bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs dev /dev
exec >/dev/console 2>&1

HOST=10.0.2.2        # QEMU's user network
USBIP_PORT=3240
EXIT_PASSED=16       # QEMU makes 2 * 16 + 1 of it
EXIT_FAILED=1
log=/tmp/log
n_passed=0

# leave CODE: QEMU ends at once, by its isa-debug-exit device.
leave() {
  sleep 0.2  # the console's last words
  printf "\\$(printf '%03o' "$1")" | dd of=/dev/port bs=1 seek=244 2>/dev/null
  poweroff -f
}

failed() {
  echo "vm: FAILED: $*"
  sed 's/^/vm:   | /' "$log"
  dmesg | grep -iE 'usb|vhci|ftdi|oops|bug:|segfault' | tail -n 15 | sed 's/^/vm:   kernel: /'
  leave $EXIT_FAILED
}

# step WHAT COMMAND...: COMMAND must end well within 60 s (functions bound their own waits).
step() {
  what=$1
  shift
  : > "$log"
  case $(type "$1") in
    *function*) "$@" >> "$log" 2>&1 || failed "$what" ;;
    *) timeout 60 "$@" >> "$log" 2>&1 || failed "$what (exit $?)" ;;
  esac
  n_passed=$((n_passed + 1))
  read -r up _ < /proc/uptime
  echo "vm: ok $up s: $what"
}

# wait_for SECONDS COMMAND...: until it succeeds.
wait_for() {
  tries=$(($1 * 10))
  shift
  while ! "$@"; do
    tries=$((tries - 1))
    [ $tries -gt 0 ] || { echo "in vain: $*"; return 1; }
    sleep 0.1
  done
}

# The sysfs folder of the Falcon; nothing when there is none.
falcon() {
  for device in /sys/bus/usb/devices/*; do
    [ "$(cat "$device/idVendor" 2>/dev/null):$(cat "$device/idProduct" 2>/dev/null)" = 0403:cb48 ] && echo "$device"
  done
}
is_there() { [ -n "$(falcon)" ]; }
is_gone() { [ -z "$(falcon)" ]; }

# equal WHAT IS SHOULD
equal() { [ "$2" = "$3" ] || { echo "$1 is '$2', should be '$3'"; return 1; }; }

modules() {
  for module in usb-common usbcore usbip-core vhci-hcd usbserial ftdi_sio e1000; do
    insmod /lib/modules/$module.ko || return 1
  done
}

network() {
  ifconfig lo 127.0.0.1 up && wait_for 5 test -e /sys/class/net/eth0 && ifconfig eth0 10.0.2.15 up &&
    wait_for 10 grep -q 1 /sys/class/net/eth0/carrier
}

exported() { usbip --tcp-port "$2" list -r "$1" | tee -a "$log" | grep -q '1-1:.*(0403:cb48)'; }

# attach HOST PORT: and wait until the kernel has read its descriptors.
attach() { usbip --tcp-port "$2" attach -r "$1" -b 1-1 && wait_for 10 is_there && wait_for 10 configured; }
configured() { [ "$(cat "$(falcon)/bConfigurationValue" 2>/dev/null)" = 1 ]; }

attributes() {
  at=$(falcon)
  equal speed "$(cat "$at/speed")" 12 && equal product "$(cat "$at/product")" "FALCON HAPTIC" &&
    equal serial "$(cat "$at/serial")" "$falcon_serial" && equal bcdDevice "$(cat "$at/bcdDevice")" 0600 &&
    equal bNumInterfaces "$(cat "$at/bNumInterfaces" | tr -d ' ')" 1 &&
    equal descriptors "$(od -An -v -tx1 "$at/descriptors" | tr -d ' \n')" \
      1201000200000008030448cb000601020301"09022000010100a02d""0904000002ffffff02""07058102400000""07050202400000"
}

unclaimed() { driver=$(readlink "$(falcon)":1.0/driver); equal "driver of the interface" "$driver" ""; }

libusb_list() {
  equal list "$(list)" "0403:cb48 release 0600 speed 2 product \"FALCON HAPTIC\" serial \"$falcon_serial\"\
 endpoint 81 bulk 64 endpoint 02 bulk 64"
}

# vhci-hcd hangs up when an answer comes after it was told that there is none.
cancelled() { timeout 50 cancel 1000 && is_there && ! dmesg | grep -E 'cannot find a urb|stop threads'; }

# The kernel's own FT232R driver, told to take the Falcon, has the PIC's handshake by a plain tty.
kernel_driver() {
  echo 0403 cb48 > /sys/bus/usb-serial/drivers/ftdi_sio/new_id || return 1
  wait_for 5 test -c /dev/ttyUSB0 && dmesg | grep -q 'Detected FT232R' || return 1
  # What the program before set stays in the chip.
  equal "latency timer" "$(cat /sys/bus/usb-serial/devices/ttyUSB0/latency_timer)" 4 || return 1
  stty -F /dev/ttyUSB0 9600 raw -echo -crtscts min 0 time 50 && exec 3<>/dev/ttyUSB0 || return 1
  printf '\nC\r' >&3
  answer=$(timeout 10 head -c 4 <&3 | od -An -v -tx1 | tr -d ' \n')
  exec 3>&-
  equal "answer of the PIC" "$answer" 0a442c0d
}

busy() { timeout 30 plain 1 2>&1 | tee -a "$log" | grep -q LIBUSB_ERROR_BUSY; }
# With the module goes what it was told. The tty takes a moment to close.
release() {
  echo "$(basename "$(falcon)"):1.0" > /sys/bus/usb/drivers/ftdi_sio/unbind && unclaimed && wait_for 10 rmmod ftdi_sio
}

# A whole container of the boot ROM with one word of program (docs/PROTOCOL.md 4).
make_image() {
  { printf '\252\010' && head -c 16 /dev/zero && printf '\077\000\002\200\001\000\077\000\002\200\000\000\000\000'; } \
    > /tmp/image && equal bytes "$(wc -c < /tmp/image)" 32
}
driver_lists() { palpate-falcon list | tee -a "$log" | grep -q "^$falcon_serial .*ready to be used"; }

# Its verdict on the time that replies take is about this machine: a bad one (exit 1) is none here.
driver_exchanges() {
  timeout 60 palpate-falcon rate --firmware /tmp/image --exchanges 300 --rate-min-hz 0 > /tmp/rate
  code=$?
  cat /tmp/rate
  n=$(sed -n 's/^300 requests in .*: \([0-9]*\) replies.*/\1/p' /tmp/rate)
  [ $code -le 1 ] && [ "${n:-0}" -ge 250 ]
}

n_urbs() { cat "$(falcon)/urbnum" 2>/dev/null || echo 0; }
begin_long_run() {
  plain 10000000 > /tmp/long 2>&1 &
  long=$!
  before=$(n_urbs)
  wait_for 20 is_busy
}
is_busy() { [ "$(n_urbs)" -gt $((before + 200)) ]; }
long_run_sees_it() {
  wait_for 10 ended || { kill -9 $long; return 1; }
  wait $long
  code=$?
  cat /tmp/long
  equal "exit code" $code 1 && grep -q LIBUSB_ERROR_NO_DEVICE /tmp/long
}
ended() { ! kill -0 $long 2>/dev/null || grep -q '^State:.*Z' /proc/$long/status; }

detach() { usbip detach -p "$(usbip port 2>/dev/null | sed -n 's/^Port 0*\([0-9]\+\):.*/\1/p' | head -1)"; }

begin_simulator() {
  palpate-falcon-sim usbip --bus /tmp/bus --serial "$falcon_serial" > /tmp/simulator 2>&1 &
  simulator=$!
  wait_for 10 exported 127.0.0.1 $USBIP_PORT
}
end_simulator() {
  palpate-falcon-sim quit --bus /tmp/bus || return 1
  wait $simulator
  equal "the simulator's exit code" $? 0
}

echo
echo "vm: Linux $(uname -r)"
step "the kernel takes its modules" modules
step "the network is up" network
step "usbip sees the host's Falcon" exported $HOST "$falcon_port"
step "attached; the kernel has enumerated it" attach $HOST "$falcon_port"
step "sysfs shows an FT232R in the Falcon's name, byte for byte" attributes
step "ftdi_sio leaves it alone" unclaimed
step "libusb lists it" libusb_list
step "booted, 300 exchanges" plain 300
step "an image" make_image
step "palpate-falcon lists it" driver_lists
step "palpate-falcon boots it, 300 exchanges" driver_exchanges
step "1000 reads cancelled early, late and just in time" cancelled
step "ftdi_sio, told to, finds an FT232R and has the PIC's answer" kernel_driver
step "then a plain program cannot claim it" busy
step "but palpate-falcon can, and boots it" palpate-falcon boot --firmware /tmp/image
step "ftdi_sio is gone" release
step "booted again, 60 exchanges" plain 60
step "a long run has begun" begin_long_run
step "detached" detach
step "the run ends with LIBUSB_ERROR_NO_DEVICE" long_run_sees_it
step "the kernel has forgotten it" wait_for 10 is_gone
step "attached once more" attach $HOST "$falcon_port"
step "booted, 60 exchanges" plain 60
step "detached for good" detach
step "gone" wait_for 10 is_gone

step "a simulator in here, over loopback" begin_simulator
step "attached" attach 127.0.0.1 $USBIP_PORT
step "libusb lists it" libusb_list
step "a long run has begun" begin_long_run
step "unplugged for a second" palpate-falcon-sim fault --bus /tmp/bus "unplug at_s=0 for_s=1"
step "the run ends with LIBUSB_ERROR_NO_DEVICE" long_run_sees_it
step "the kernel has forgotten it" wait_for 10 is_gone
step "plugged in again" wait_for 10 exported 127.0.0.1 $USBIP_PORT
step "attached" attach 127.0.0.1 $USBIP_PORT
step "booted, 300 exchanges" plain 300
step "detached" detach
step "the simulator ends well" end_simulator
echo "vm: passed $n_passed"
leave $EXIT_PASSED
