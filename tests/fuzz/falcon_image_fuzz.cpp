// Any file as firmware: what is accepted is a whole boot container by another reading of it, what is refused
// has its place within the file, and a digest never depends on more than the bytes.
#include "firmware/falcon/falcon.h"
#include "firmware/falcon/image.h"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;

fuzz::Reached whole("whole container"), broken("container broken behind its header");

// Bytes of the container that `bytes` begins with, by words; 0 when there is none.
std::size_t length_of(fuzz::Bytes bytes) {
    const auto word = [&](std::size_t i) -> std::size_t {
        return 2 * i + 1 < bytes.size() ? bytes[2 * i] + 256U * bytes[2 * i + 1] : 0U;
    };
    std::size_t at = 11;  // key, eight reserved words, entry
    while (word(at) != 0) at += 3 + word(at);
    return 2 * (at + 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    pal_image_info info{};
    const pal_image_problem problem = pal_image_check(data, size, &info);
    require(pal_image_check(data, size, nullptr) == problem);
    require(info.problem_at <= size);
    require((pal_image_words(problem)[0] == '\0') == (problem == PAL_IMAGE_OK));
    if (problem == PAL_IMAGE_OK) {
        whole.note();
        require(length_of({data, size}) == size);
        require(size == 24 + 6 * std::size_t{info.n_blocks} + 2 * std::size_t{info.n_words});
        require(info.n_blocks > 0 && info.entry < 0x400000);
    } else if (problem == PAL_IMAGE_CUT || problem == PAL_IMAGE_TRAILING) {
        broken.note();
        require(length_of({data, size}) != size || info.n_blocks == 0 || problem == PAL_IMAGE_CUT);
    }
    std::uint8_t digest[PAL_SHA256_BYTES];
    pal_sha256(data, size, digest);
    require(pal_image_name(digest) == nullptr);
    pal_falcon falcon;
    pal_falcon_config config = pal_falcon_config_default();
    config.boot.image = data;
    config.boot.n_image_bytes = size;
    const pal_falcon_refusal refusal = pal_falcon_init(&falcon, &config);
    require((refusal == PAL_FALCON_OK) == (problem == PAL_IMAGE_OK && data != nullptr));
    return 0;
}
