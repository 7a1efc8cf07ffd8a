// Any transfers at any times, any faults: the device model at its USB wire. No packet is malformed, no
// wake-up comes too late, motors keep their limits and stand still without a firmware, and how often the
// device is advanced makes no difference. The input is a row of letters with what each needs behind it, so
// that seeds can be read.
#include "sim/falcon/usb_device.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;

fuzz::Reached booted("firmware booted"), replied("request answered"), struck("fault struck"),
    away("unplugged or without supply");

constexpr std::size_t OPS_MAX = 200;
constexpr std::uint64_t US_MAX = 1000000;  // of device time for one input

class Bench {
public:
    /// `n_parts`: each wait is done in so many advances.
    Bench(std::uint8_t options, unsigned n_parts)
        : device_(std::make_unique<pal_usb_device>()),
          probe_(std::make_unique<pal_usb_device>()),
          n_parts_(n_parts) {
        pal_usb_device_config config = pal_usb_device_config_default();
        config.falcon.n_substeps = 1;  // the wire is what is tested here
        config.start_us = 7;
        config.instant = (options & 1U) != 0;
        config.running = (options & 2U) != 0;
        config.unplug_keeps_firmware = (options & 4U) != 0;
        config.loader.zero_before_answer = (options & 8U) != 0;
        config.loader.xoff_before_echo = (options & 16U) != 0;
        config.loader.start_us = (options & 32U) != 0 ? 3000 : 0;
        config.falcon.homed_needs_bit = (options & 64U) != 0;
        now_us_ = config.start_us;
        require(pal_usb_device_init(device_.get(), &config));
    }

    std::uint64_t run(fuzz::Bytes bytes) {
        for (std::size_t n = 0; n < OPS_MAX && !bytes.empty() && now_us_ < US_MAX; ++n) {
            op(bytes);
            check();
        }
        return digest_;
    }

    void note() const {
        const pal_usb_device_truth truth = pal_usb_device_read(device_.get());
        if (truth.n_boots > 0) booted.note();
        if (truth.n_replies > 0) replied.note();
        if (truth.n_strikes > 0) struck.note();
        if (!truth.present || !truth.powered) away.note();
    }

private:
    void op(fuzz::Bytes& bytes) {
        switch (fuzz::take<std::uint8_t>(bytes)) {
            case 'B':
                return boot(fuzz::take<std::uint8_t>(bytes));
            case 'C':
                return control(fuzz::take<std::array<std::uint8_t, 8>>(bytes));
            case 'O':
                return out_some(bytes);
            case 'Q':
                return out("<AAABAAACAAADIA>");
            case 'I':
                return in();
            case 'R':
                return read();
            case 'F':
                return inject(bytes);
            case 'H':
                return pal_usb_device_heal(device_.get());
            case 'E':  // '>' sends at once
                return vendor(0x06, 0x013E);
            case 'L':
                return vendor(0x09, fuzz::take<std::uint8_t>(bytes));
            case 'D':
                return vendor(0x01, fuzz::take<std::uint8_t>(bytes) % 2 == 1 ? 0x0101 : 0x0100);
            default:
                return wait(fuzz::take<std::uint16_t>(bytes));
        }
    }

    void mix(std::uint64_t value) { digest_ = (digest_ ^ value) * 0x100000001B3U; }

    void wait(std::uint64_t us) {
        for (unsigned n = n_parts_; n > 1 && us >= n; --n) {
            now_us_ += us / n;
            us -= us / n;
            pal_usb_device_advance(device_.get(), now_us_);
        }
        now_us_ += us;
        pal_usb_device_advance(device_.get(), now_us_);
    }

    void control(const std::array<std::uint8_t, 8>& setup) {
        std::array<std::uint8_t, 64> data{};
        const std::size_t wanted = setup[6] + 256U * setup[7];
        const std::size_t n_bytes = std::min(wanted, data.size());
        const int n = pal_usb_device_control(device_.get(), setup.data(), data.data(), n_bytes);
        require(n >= PAL_USB_GONE && n <= static_cast<int>(n_bytes));
        require((n == PAL_USB_GONE) == !pal_usb_device_present(device_.get()));
        mix(static_cast<std::uint64_t>(n));
        for (int i = 0; i < n; ++i) mix(data[static_cast<std::size_t>(i)]);
    }
    void vendor(std::uint8_t request, unsigned value) {
        control({0x40, request, static_cast<std::uint8_t>(value & 0xFFU),
                 static_cast<std::uint8_t>(value >> 8U), 0, 0, 0, 0});
    }

    void out(const std::string& bytes) {
        const int n = pal_usb_device_out(device_.get(), reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                         bytes.size());
        require(n == 0 || n == static_cast<int>(bytes.size()) || n == PAL_USB_STALL || n == PAL_USB_GONE);
        mix(static_cast<std::uint64_t>(n));
    }
    void out_some(fuzz::Bytes& bytes) {
        const std::size_t n = std::min<std::size_t>(fuzz::take<std::uint8_t>(bytes) % 66, bytes.size());
        out(std::string(fuzz::text_of(bytes.first(n))));
        bytes = bytes.subspan(n);
    }

    void in() {
        std::array<std::uint8_t, PAL_USB_PACKET_BYTES> packet{};
        const int n = pal_usb_device_in(device_.get(), packet.data());
        require(n >= PAL_USB_GONE && n != 1 && n <= PAL_USB_PACKET_BYTES);
        if (n > 0) require((packet[0] & 0x0FU) == 1 && (packet[1] & 0x95U) == 0);
        mix(static_cast<std::uint64_t>(n));
        for (int i = 0; i < n; ++i) mix(packet[static_cast<std::size_t>(i)]);
        if (n == 0) check_next();
    }
    /// Waits for a packet as a host controller would.
    void read() {
        const std::uint64_t end_us = now_us_ + 20000;
        for (int i = 0; i < 40; ++i) {
            in();
            const std::uint64_t next_us = pal_usb_device_next_us(device_.get());
            if (next_us <= now_us_ || next_us > end_us) return;
            wait(next_us - now_us_);
        }
    }

    /// After a NAK: the next trial lies ahead, and one microsecond before it there is nothing yet.
    void check_next() {
        const std::uint64_t next_us = pal_usb_device_next_us(device_.get());
        require(next_us > now_us_);
        if (next_us == UINT64_MAX || next_us > now_us_ + 300000) return;
        *probe_ = *device_;
        pal_usb_device_advance(probe_.get(), next_us - 1);
        std::uint8_t packet[PAL_USB_PACKET_BYTES];
        require(pal_usb_device_in(probe_.get(), packet) == 0);
    }

    void boot(std::uint8_t n_words) {
        vendor(0x00, 0);
        vendor(0x04, 8);
        vendor(0x03, 0x4138);
        vendor(0x01, 0x0101);
        out("\nC\r");
        wait(9000);
        vendor(0x01, 0x0100);
        vendor(0x03, 0x0015);
        out("A");
        wait(200);
        std::string image("\xAA\x08");
        image += std::string(16, '\0') + std::string("\x3F\0\2\x80", 4);
        if (n_words > 0) {
            image += static_cast<char>(n_words);
            image += '\0' + std::string("\x3F\0\2\x80", 4) + std::string(2U * n_words, 'x');
        }
        image += std::string(2, '\0');
        for (std::size_t at = 0; at < image.size(); at += 62) {
            out(image.substr(at, 62));
            wait(4500);
            in();
        }
        vendor(0x03, 0x0002);
        vendor(0x09, 1);
    }

    /// A line of the text form.
    void inject(fuzz::Bytes& bytes) {
        const auto end = std::find(bytes.begin(), bytes.end(), '\n');
        const auto n = static_cast<std::size_t>(end - bytes.begin());
        const std::string_view line = fuzz::text_of(bytes.first(n));
        pal_usb_fault fault{};
        pal_usb_fault_error error{};
        const int n_faults = pal_usb_faults_parse(line.data(), line.size(), &fault, 1, &error);
        require(n_faults >= 0 || (error.line == 1 && error.message[0] != '\0'));
        if (n_faults == 1) {
            require(pal_usb_fault_problem(&fault) == nullptr);
            fault.every_us =
                std::max<std::uint64_t>(fault.every_us, 100);  // a burst each microsecond takes too long
            static_cast<void>(pal_usb_device_inject(device_.get(), &fault));
        }
        bytes = bytes.subspan(std::min(n + 1, bytes.size()));
    }

    void check() const {
        const pal_usb_device_truth truth = pal_usb_device_read(device_.get());
        for (std::size_t i = 0; i < 3; ++i) {
            require(std::abs(int{truth.motor_counts[i]}) <= PAL_FALCON_MOTOR_MAX);
            if (truth.dsp != PAL_DSP_RUN) require(truth.motor_counts[i] == 0);
            require(std::isfinite(truth.position_m[i]));
        }
        require(truth.now_us == now_us_);
        require(truth.homed <= 7 && truth.leds <= 15 && truth.spare <= 15);
    }

    std::unique_ptr<pal_usb_device> device_, probe_;
    unsigned n_parts_;
    std::uint64_t now_us_ = 0, digest_ = 0xCBF29CE484222325U;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes{data, size};
    const auto options = fuzz::take<std::uint8_t>(bytes);
    Bench coarse(options, 1);
    const std::uint64_t digest = coarse.run(bytes);
    coarse.note();
    Bench fine(options, 3);
    require(fine.run(bytes) == digest);
    return 0;
}
