"""A Falcon by pyusb: boot with a synthetic image, then N exchanges. Exit 0 when all were answered well."""
import sys

import usb.core
import usb.util

IMAGE = bytes([0xAA, 0x08] + 16 * [0] + [0x3F, 0, 2, 0x80, 1, 0, 0x3F, 0, 2, 0x80, 0, 0, 0, 0])
MS = 1000


def request(device, what, *values):
    for value in values:
        device.ctrl_transfer(0x40, what, value, 0, None, MS)


def read(device, n):
    got = b""
    for _ in range(1000):
        got += bytes(device.read(0x81, 64, MS))[2:]
        if len(got) >= n:
            return got[:n]
    raise RuntimeError(f"{n} bytes did not come")


def boot(device):
    request(device, 0x00, 1, 2)
    request(device, 0x09, 16)
    request(device, 0x03, 0x4138)
    request(device, 0x04, 8)
    request(device, 0x02, 0)
    request(device, 0x01, 0x0200, 0x0100, 0x0101)
    device.write(0x02, b"\nC\r", MS)
    assert read(device, 4) == b"\nD,\r"
    request(device, 0x01, 0x0100)
    request(device, 0x03, 0x0015)
    device.write(0x02, b"A", MS)
    assert read(device, 1) == b"A"
    device.write(0x02, IMAGE, MS)
    assert read(device, len(IMAGE)) == IMAGE
    request(device, 0x09, 1)
    request(device, 0x03, 2)
    request(device, 0x00, 1, 2)


def main():
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    device = usb.core.find(idVendor=0x0403, idProduct=0xCB48)
    assert device is not None, "no Falcon found"
    assert usb.util.get_string(device, device.iProduct) == "FALCON HAPTIC"
    boot(device)
    for _ in range(n):
        device.write(0x02, b"<AAAAAAAAAAAAAA>", MS)
        answer = read(device, 16)
        assert answer[:1] == b"<" and answer[15:] == b">", answer
    usb.util.dispose_resources(device)
    print(f"pyusb: {n} exchanges")


main()
