#include "tests/sim/umockdev/usbfs.hpp"

#include <sys/ioctl.h>
// <sys/ioctl.h> first: the next one needs its macros.
#include <linux/usbdevice_fs.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <vector>

namespace {

constexpr const char* kNode = "/dev/bus/usb/001/002";
constexpr uint64_t kFrameUs = 1000;
constexpr uint64_t kPatienceUs = 10'000'000;  // of the device's time, for one transfer

/// A kernel's word for a refusal of the device.
int status_of(int refusal) {
    return refusal == PAL_USB_GONE ? -ESHUTDOWN : -EPIPE;
}

std::vector<uint8_t> descriptor(pal_usb_device& device, uint8_t type, uint8_t index, uint8_t n_bytes) {
    std::vector<uint8_t> bytes(n_bytes);
    const std::array<uint8_t, 8> setup = {0x80, 6, index, type, 0, 0, n_bytes, 0};
    const int n = pal_usb_device_control(&device, setup.data(), bytes.data(), bytes.size());
    if (n < 0) throw std::runtime_error("a descriptor is refused");
    bytes.resize(static_cast<std::size_t>(n));
    return bytes;
}

std::string text(pal_usb_device& device, uint8_t index) {
    const auto bytes = descriptor(device, 3, index, 255);
    std::string out;
    for (std::size_t i = 2; i < bytes.size(); i += 2) out += static_cast<char>(bytes[i]);
    return out;
}

/// What a kernel would show of the device, from its own answers, in umockdev's form.
std::string describe(pal_usb_device& device) {
    auto all = descriptor(device, 1, 0, 18);
    const auto configuration = descriptor(device, 2, 0, 255);
    const auto at = [&all](std::size_t i) { return all.at(i); };
    std::array<char, 512> words{};
    std::snprintf(words.data(), words.size(),
                  "P: /devices/usb1/1-1\n"
                  "E: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: BUSNUM=001\nE: DEVNUM=002\nE: DEVNAME=%s\n"
                  "A: busnum=1\\n\nA: devnum=2\\n\nA: speed=12\\n\nA: bConfigurationValue=%d\\n\n"
                  "A: idVendor=%02x%02x\\n\nA: idProduct=%02x%02x\\n\n",
                  kNode, configuration.at(5), at(9), at(8), at(11), at(10));
    const std::array<uint8_t, 3> strings = {at(14), at(15), at(16)};
    all.insert(all.end(), configuration.begin(), configuration.end());
    std::string out = words.data();
    out += "A: manufacturer=" + text(device, strings[0]) + "\\n\nA: product=" + text(device, strings[1]) +
           "\\n\nA: serial=" + text(device, strings[2]) + "\\n\nH: descriptors=";
    for (const uint8_t byte : all) {
        std::snprintf(words.data(), words.size(), "%02X", byte);
        out += words.data();
    }
    // A plain file: always writable, so libusb looks for ended URBs at once, and here they have always ended.
    return out + "\nN: bus/usb/001/002\n";
}

}  // namespace

Usbfs::Usbfs(pal_usb_device& device)
    : device_(device), bed_(umockdev_testbed_new()), handler_(umockdev_ioctl_base_new()) {
    g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(on_ioctl), this);
    g_signal_connect(handler_, "client-vanished", G_CALLBACK(on_vanished), this);
    const std::array<uint8_t, 8> set_configuration = {0x00, 9, 1, 0, 0, 0, 0, 0};
    if (pal_usb_device_control(&device_, set_configuration.data(), nullptr, 0) != 0 ||
        umockdev_testbed_attach_ioctl(bed_, kNode, handler_, nullptr) == FALSE ||
        umockdev_testbed_add_from_string(bed_, describe(device_).c_str(), nullptr) == FALSE) {
        throw std::runtime_error("umockdev does not take the device");
    }
}

Usbfs::~Usbfs() {
    umockdev_testbed_detach_ioctl(bed_, kNode, nullptr);
    g_object_unref(handler_);
    g_object_unref(bed_);
    forget();
}

pal_usb_device_truth Usbfs::truth() {
    const std::scoped_lock lock(mutex_);
    return pal_usb_device_read(&device_);
}

std::string Usbfs::refused() {
    const std::scoped_lock lock(mutex_);
    return refused_;
}

void Usbfs::forget() {
    for (UMockdevIoctlData* urb : ended_) g_object_unref(urb);
    ended_.clear();
}

void Usbfs::on_vanished(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* /*client*/, gpointer self) {
    auto* usbfs = static_cast<Usbfs*>(self);
    const std::scoped_lock lock(usbfs->mutex_);
    usbfs->forget();
}

gboolean Usbfs::on_ioctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer self) {
    auto* usbfs = static_cast<Usbfs*>(self);
    const std::scoped_lock lock(usbfs->mutex_);
    usbfs->serve(client);
    return TRUE;
}

void Usbfs::serve(UMockdevIoctlClient* client) {
    switch (umockdev_ioctl_client_get_request(client)) {
        case USBDEVFS_GET_CAPABILITIES: {
            const guint32 can =
                USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION | USBDEVFS_CAP_NO_PACKET_SIZE_LIM;
            UMockdevIoctlData* answer =
                umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof can, nullptr);
            *reinterpret_cast<guint32*>(answer->data) = can;
            g_object_unref(answer);
            umockdev_ioctl_client_complete(client, 0, 0);
            return;
        }
        case USBDEVFS_CLAIMINTERFACE:
        case USBDEVFS_RELEASEINTERFACE:
            umockdev_ioctl_client_complete(client, 0, 0);
            return;
        case USBDEVFS_GETDRIVER:
        case USBDEVFS_IOCTL:
            umockdev_ioctl_client_complete(client, -1, ENODATA);
            return;
        case USBDEVFS_SUBMITURB:
            submit(client);
            return;
        case USBDEVFS_REAPURBNDELAY:
            reap(client);
            return;
        default:
            break;
    }
    if (refused_.empty()) refused_ = "ioctl " + std::to_string(umockdev_ioctl_client_get_request(client));
    umockdev_ioctl_client_complete(client, -1, ENOTTY);
}

void Usbfs::submit(UMockdevIoctlClient* client) {
    UMockdevIoctlData* data =
        umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(usbdevfs_urb), nullptr);
    auto& urb = *reinterpret_cast<usbdevfs_urb*>(data->data);
    UMockdevIoctlData* buffer = umockdev_ioctl_data_resolve(data, offsetof(usbdevfs_urb, buffer),
                                                            static_cast<gsize>(urb.buffer_length), nullptr);
    urb.actual_length = 0;
    urb.status = transfer(urb, buffer->data);
    g_object_unref(buffer);
    ended_.push_back(data);
    umockdev_ioctl_client_complete(client, 0, 0);
}

void Usbfs::reap(UMockdevIoctlClient* client) {
    if (ended_.empty()) {
        umockdev_ioctl_client_complete(client, -1, EAGAIN);
        return;
    }
    UMockdevIoctlData* urb = ended_.front();
    ended_.pop_front();
    UMockdevIoctlData* answer =
        umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(gpointer), nullptr);
    umockdev_ioctl_data_set_ptr(answer, 0, urb);
    g_object_unref(answer);
    g_object_unref(urb);
    umockdev_ioctl_client_complete(client, 0, 0);
}

void Usbfs::pass(uint64_t us) {
    now_us_ += us;
    pal_usb_device_advance(&device_, now_us_);
}

/// The URB's status: 0 or a negative errno.
int Usbfs::transfer(usbdevfs_urb& urb, guint8* buffer) {
    pass(kFrameUs);
    if (urb.type == USBDEVFS_URB_TYPE_CONTROL) return control(urb, buffer);
    if (urb.type == USBDEVFS_URB_TYPE_BULK && urb.endpoint == PAL_USB_EP_OUT) return out(urb, buffer);
    if (urb.type == USBDEVFS_URB_TYPE_BULK && urb.endpoint == PAL_USB_EP_IN) return in(urb, buffer);
    refused_ = "endpoint " + std::to_string(urb.endpoint);
    return -ENOENT;
}

int Usbfs::control(usbdevfs_urb& urb, guint8* buffer) {
    const auto n_bytes = static_cast<std::size_t>(buffer[6] | buffer[7] << 8);
    const int n = pal_usb_device_control(&device_, buffer, buffer + 8, n_bytes);
    urb.actual_length = std::max(n, 0);
    return n >= 0 ? 0 : status_of(n);
}

int Usbfs::out(usbdevfs_urb& urb, const guint8* buffer) {
    const uint64_t last_us = now_us_ + kPatienceUs;
    while (urb.actual_length < urb.buffer_length && now_us_ < last_us) {
        const int n_bytes = std::min(urb.buffer_length - urb.actual_length, int{PAL_USB_PACKET_BYTES});
        const int n =
            pal_usb_device_out(&device_, buffer + urb.actual_length, static_cast<std::size_t>(n_bytes));
        if (n < 0) return status_of(n);
        urb.actual_length += n;
        if (n == 0) pass(kFrameUs);
    }
    return urb.actual_length == urb.buffer_length ? 0 : -ETIMEDOUT;
}

int Usbfs::in(usbdevfs_urb& urb, guint8* buffer) {
    const uint64_t last_us = now_us_ + kPatienceUs;
    while (urb.actual_length < urb.buffer_length) {
        std::array<uint8_t, PAL_USB_PACKET_BYTES> packet{};
        const int n = pal_usb_device_in(&device_, packet.data());
        if (n < 0) return status_of(n);
        if (n == 0) {
            const uint64_t next_us = pal_usb_device_next_us(&device_);
            if (next_us > last_us) return -ETIMEDOUT;
            pass(std::max(next_us, now_us_ + 1) - now_us_);
            continue;
        }
        if (n > urb.buffer_length - urb.actual_length) return -EOVERFLOW;
        std::copy_n(packet.begin(), n, buffer + urb.actual_length);
        urb.actual_length += n;
        if (n < PAL_USB_PACKET_BYTES) break;
    }
    return 0;
}
