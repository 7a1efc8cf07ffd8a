// Modbus frames from anyone: whatever the bytes, the reader stays inside them, and lets only requests through
// that libmodbus answers from the map: an exception from it would come after its pause of 0.5 s. The same
// bytes as an address to serve: loopback, or Error.
#include <modbus.h>
#include <sys/socket.h>

#include <memory>

#include "host/rig/frame.hpp"
#include "host/rig/map.hpp"
#include "host/rig/socket.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;
using namespace palpate::rig;

fuzz::Reached frames("whole frame"), reads("read answered"), writes("write answered"),
    served("address served");

constexpr Sizes SIZES{.n_words = N_WORDS, .n_coils = N_COILS};

/// libmodbus on one end of a socket pair, the client on the other.
class Answerer {
public:
    Answerer() {
        require(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends_.data()) == 0);
        require(context_ != nullptr && mapping_ != nullptr);
        modbus_set_socket(context_.get(), ends_[0]);
    }
    /// The function code of the answer.
    std::uint8_t operator()(fuzz::Bytes frame) {
        const int n =
            modbus_reply(context_.get(), frame.data(), static_cast<int>(frame.size()), mapping_.get());
        std::array<std::uint8_t, FRAME_MAX_BYTES> answer{};
        require(n > 8 && ::recv(ends_[1], answer.data(), answer.size(), MSG_DONTWAIT) == n);
        return answer[7];
    }

private:
    std::array<int, 2> ends_{};
    std::unique_ptr<modbus_t, decltype(&modbus_free)> context_{modbus_new_tcp("127.0.0.1", 0), &modbus_free};
    std::unique_ptr<modbus_mapping_t, decltype(&modbus_mapping_free)> mapping_{
        modbus_mapping_new(N_COILS, 0, 0, N_WORDS), &modbus_mapping_free};
};

void check_answerable(fuzz::Bytes frame) {
    static Answerer answerer;
    require(answerer(frame) == frame[7]);
    const CoilWrite write = coil_write(frame);
    require(write.mask < 1U << SIZES.n_coils);
    require((write.values & ~write.mask) == 0);
    const bool writing = frame[7] == 5 || frame[7] == 15;
    require(frame.size() ==
            (frame[7] == 15 ? 13U + frame[12] : 12U));  // docs/MODBUS.md: exception 03 otherwise
    require((write.mask != 0) == writing);
    (writing ? writes : reads).note();
}

void check_frames(fuzz::Bytes rest) {
    for (;;) {
        const std::optional<std::size_t> length = frame_bytes(rest);
        if (!length) return;
        require(*length <= FRAME_MAX_BYTES);
        if (*length == 0) {
            require(rest.size() < FRAME_MAX_BYTES);  // a full buffer always holds a whole frame
            return;
        }
        require(*length <= rest.size());
        // Of just this size, so that the address sanitizer sees a byte too far.
        const std::unique_ptr<std::uint8_t[]> own(new std::uint8_t[*length]);
        std::copy_n(rest.begin(), *length, own.get());
        const fuzz::Bytes frame(own.get(), *length);
        require(frame_bytes(frame) == length);
        require(frame_bytes(frame.first(*length - 1)) == 0U);
        frames.note();
        if (verdict_on(frame, SIZES) == Verdict::Answer) check_answerable(frame);
        rest = rest.subspan(*length);
    }
}

void check_address(fuzz::Bytes bytes) {
    try {
        require(loopback_endpoint(std::string(fuzz::text_of(bytes))).ip.starts_with("127."));
        served.note();
    } catch (const Error&) {
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    check_frames({data, size});
    check_address({data, size});
    return 0;
}
