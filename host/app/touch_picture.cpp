#include "host/app/touch_picture.hpp"

#ifdef PALPATE_HAS_VIEW
#include "host/app/view_source.hpp"
#include "host/view/offscreen.hpp"
#endif

namespace palpate::app {

#ifdef PALPATE_HAS_VIEW
std::string draw_touch(const std::filesystem::path& png, const Prepared& prepared, const RunResult& result) {
    try {
        const view::Source source = view_source(*prepared.world, *prepared.field, result.ticks);
        view::screenshot(source, peak_time_s(result.ticks), view::home_camera(source.body), 1280, 720, png);
        return "";
    } catch (const std::runtime_error& error) {
        return std::string("touch.png is missing: ") + error.what();
    }
}
#else
std::string draw_touch(const std::filesystem::path&, const Prepared&, const RunResult&) {
    return "touch.png is missing: built without the viewer (PALPATE_VIEW)";
}
#endif

}  // namespace palpate::app
