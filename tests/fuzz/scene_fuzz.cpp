// A scene's text and one --set on arbitrary bytes: a scene that resolves to itself, or Error on one line, and
// nothing else. What stands before the first zero byte is the --set.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "host/scene/scene.hpp"

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace palpate;
    const std::string_view bytes(reinterpret_cast<const char*>(data), size);
    const std::size_t zero = bytes.find('\0');
    const bool overridden = zero != std::string_view::npos;
    const std::vector<std::string> set(overridden ? 1 : 0,
                                       std::string(bytes.substr(0, overridden ? zero : 0)));
    try {
        const scene::Scene first = scene::parse(bytes.substr(overridden ? zero + 1 : 0), "fuzz.toml", set);
        scene::Scene second;
        try {
            second = scene::parse(scene::resolved_toml(first, "out"), "out/scene.toml");
        } catch (const scene::Error&) {
            std::abort();  // what was accepted must be accepted again
        }
        require(second.hash == first.hash);
        require(first.skin.young_pa > 0.0 && first.skin.thickness_m > 0.0 && first.touch.force_max_n <= 8.9);
        for (std::size_t i = 1; i < first.hand.path.size(); ++i) {
            require(first.hand.path[i].t_s > first.hand.path[i - 1].t_s);
        }
    } catch (const scene::Error& error) {
        require(std::string_view(error.what()).find('\n') == std::string_view::npos);
    }
    return 0;
}
