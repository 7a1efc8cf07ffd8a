// The device model behind libumockdev: other people's usbfs, in place of a kernel's and of sim/usb's. Time is
// virtual: it goes on by one USB frame for each transfer and to whenever the device has an answer.
#pragma once
#include <umockdev.h>

#include <deque>
#include <mutex>
#include <string>

#include "sim/falcon/usb_device.h"

class Usbfs {
public:
    /// Plugs `device` (borrowed) into a testbed of umockdev; programs under umockdev-wrapper started from now
    /// on see it.
    explicit Usbfs(pal_usb_device& device);
    Usbfs(const Usbfs&) = delete;
    Usbfs& operator=(const Usbfs&) = delete;
    ~Usbfs();
    /// What is true inside the device. Any thread.
    [[nodiscard]] pal_usb_device_truth truth();
    /// The first thing asked for that is not served here; empty: none.
    [[nodiscard]] std::string refused();

private:
    static gboolean on_ioctl(UMockdevIoctlBase* base, UMockdevIoctlClient* client, gpointer self);
    static void on_vanished(UMockdevIoctlBase* base, UMockdevIoctlClient* client, gpointer self);
    void serve(UMockdevIoctlClient* client);
    void submit(UMockdevIoctlClient* client);
    void reap(UMockdevIoctlClient* client);
    int transfer(struct usbdevfs_urb& urb, guint8* buffer);
    int control(struct usbdevfs_urb& urb, guint8* buffer);
    int out(struct usbdevfs_urb& urb, const guint8* buffer);
    int in(struct usbdevfs_urb& urb, guint8* buffer);
    void pass(uint64_t us);
    void forget();

    std::mutex mutex_;  // umockdev calls from a thread of its own
    pal_usb_device& device_;
    uint64_t now_us_ = 0;
    std::deque<UMockdevIoctlData*> ended_;  // URBs to be reaped
    std::string refused_;
    UMockdevTestbed* bed_;
    UMockdevIoctlBase* handler_;
};
