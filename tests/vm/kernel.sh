#!/usr/bin/env bash
# tests/vm/kernel.sh FOLDER: the distribution's stock kernel below FOLDER, downloaded and unpacked, never installed.
# Prints the folder that holds vmlinuz and *.ko. What is there already is kept: a second call needs no network.
set -euo pipefail
folder=$1
metapackage=linux-image-amd64
modules=(usb-common usbcore usbip-core vhci-hcd usbserial ftdi_sio e1000)

say() { printf 'vm: %s\n' "$*" >&2; }

mkdir -p "$folder"
version=$(apt-cache depends "$metapackage" 2>/dev/null | sed -n 's/^ *Depends: \(linux-image-[0-9]\)/\1/p' | head -1)
have=$(find "$folder" -maxdepth 1 -name 'linux-image-*' -type d | sort -V | tail -1)
if [ -z "$version" ]; then
  [ -n "$have" ] || { say "the package lists do not know $metapackage; run apt-get update"; exit 2; }
  version=$(basename "$have")
fi
out=$folder/$version
if [ ! -e "$out/complete" ]; then
  scratch=$(mktemp -d "$folder/unpack.XXXXXX")
  trap 'rm -rf "$scratch"' EXIT
  say "downloading $version (about 70 MB) to $out"
  if ! (cd "$scratch" && apt-get download -qq -o APT::Sandbox::User=root "$version" >/dev/null 2>"apt.log"); then
    say "cannot download $version: $(grep -m1 '^E:' "$scratch/apt.log" || echo 'no word from apt-get')"
    say "the machine needs its package mirror once; or put $version*.deb's vmlinuz and modules into $out"
    exit 2
  fi
  dpkg-deb -x "$scratch"/*.deb "$scratch/root"
  rm -rf "$out"
  mkdir "$out"
  mv "$scratch"/root/boot/vmlinuz-* "$out/vmlinuz"
  for module in "${modules[@]}"; do
    found=$(find "$scratch/root" -name "$module.ko*" | head -1)
    [ -n "$found" ] || { say "$version has no module $module"; exit 2; }
    case $found in
      *.xz) xz -dc "$found" > "$out/$module.ko" ;;
      *.zst) zstd -qdc "$found" > "$out/$module.ko" ;;
      *) mv "$found" "$out/$module.ko" ;;
    esac
  done
  touch "$out/complete"
fi
printf '%s\n' "$out"
