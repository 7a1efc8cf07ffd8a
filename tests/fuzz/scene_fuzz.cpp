// A scene's text and its --set on arbitrary bytes: a scene that resolves to itself, or Error on one line, and
// nothing else. Lines `#set KEY=VALUE` at the top are the --set; to TOML they are comments.
#include "host/scene/scene.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;
using palpate::scene::Scene;

fuzz::Reached accepted("scene accepted"), overridden("with a --set"), resolved("with a path and a change");

constexpr std::size_t SETS_MAX = 4;

std::vector<std::string> sets_at_top_of(std::string_view text) {
    constexpr std::string_view MARK = "#set ";
    std::vector<std::string> sets;
    while (text.starts_with(MARK) && sets.size() < SETS_MAX) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        sets.emplace_back(text.substr(MARK.size(), end - MARK.size()));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return sets;
}

void check(const Scene& first) {
    Scene second;
    try {
        second = palpate::scene::parse(palpate::scene::resolved_toml(first, "out"), "out/scene.toml");
    } catch (const palpate::scene::Error&) {
        std::abort();  // what was accepted must be accepted again
    }
    require(second.hash == first.hash);
    require(first.skin.young_pa > 0.0 && first.skin.thickness_m > 0.0 && first.touch.force_max_n <= 8.9);
    for (std::size_t i = 1; i < first.hand.path.size(); ++i) {
        require(first.hand.path[i].t_s > first.hand.path[i - 1].t_s);
    }
    for (const palpate::scene::Change& change : first.changes) {
        require(change.factor[0] > 0.0 && change.factor[1] > 0.0 && change.edge_m <= 2.0 * change.radius_m);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view text = fuzz::text_of({data, size});
    const std::vector<std::string> sets = sets_at_top_of(text);
    try {
        const Scene scene = palpate::scene::parse(text, "fuzz.toml", sets);
        check(scene);
        accepted.note();
        if (!sets.empty()) overridden.note();
        if (!scene.hand.path.empty() && !scene.changes.empty()) resolved.note();
    } catch (const palpate::scene::Error& error) {
        require(std::string_view(error.what()).find('\n') == std::string_view::npos);
    }
    return 0;
}
