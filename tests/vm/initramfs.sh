#!/usr/bin/env bash
# tests/vm/initramfs.sh KERNEL_FOLDER OUT INIT PROGRAM...: a root file system for the guest: busybox, the modules, INIT,
# the programs in /bin and the libraries that ldd names for them.
set -euo pipefail
kernel=$1
out=$2
init=$3
shift 3
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
mkdir -p "$root"/{bin,dev,etc,lib/modules,proc,run,sys,tmp,var/run,usr/share}

busybox=$(command -v busybox) || { echo "vm: busybox is missing; install busybox-static" >&2; exit 2; }
if ldd "$busybox" >/dev/null 2>&1; then echo "vm: $busybox is not static; install busybox-static" >&2; exit 2; fi
cp "$busybox" "$root/bin/busybox"
cp "$init" "$root/init"
chmod 755 "$root/init"
cp "$kernel"/*.ko "$root/lib/modules/"
for program in "$@"; do
  [ -x "$program" ] || { echo "vm: $program is missing" >&2; exit 2; }
  cp "$program" "$root/bin/"
  # Lines such as "libusb-1.0.so.0 => /lib/.../libusb-1.0.so.0 (0x...)" and "/lib64/ld-linux-x86-64.so.2 (0x...)".
  while read -r library; do
    [ -e "$library" ] || { echo "vm: $program needs $library" >&2; exit 2; }
    mkdir -p "$root$(dirname "$library")"
    cp -n -L "$library" "$root$library"
  done < <(ldd "$program" | grep -oE '/[^ ]+ \(0x' | cut -d' ' -f1)
done
(cd "$root" && find . | "$busybox" cpio -o -H newc 2>/dev/null) | gzip -1 > "$out.part"
mv "$out.part" "$out"
