#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "host/app/commands.hpp"
#include "host/app/progress.hpp"
#include "host/app/run.hpp"
#include "host/app/view_source.hpp"
#include "host/record/aside.hpp"
#include "host/record/record.hpp"
#include "host/view/offscreen.hpp"
#include "host/view/window.hpp"

namespace palpate::app {
namespace {

constexpr view::Size PICTURE_SIZE{1280, 720};

struct ViewOptions {
    std::string what, screenshot;
    double at_s = -1.0;
    bool quiet = false;
};

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& words) {
    std::string line = file.string() + ": " + words;
    std::replace(line.begin(), line.end(), '\n', ' ');
    throw record::Error(line);
}

/// The scene that a record carries, to which its ticks belong; what lies beside the record may be another's.
scene::Scene scene_in(const std::filesystem::path& file, const record::Record& record) {
    const auto text = record.header.find("scene");
    if (text == record.header.end() || !text->is_string()) {
        refuse(file, "its header has no scene; a record of `palpate run` is expected");
    }
    return scene::parse(text->get<std::string>(), file);
}

/// The world of a record: with the very points that were felt, from where they lay, or beside the record, or
/// among the installed models.
std::unique_ptr<scene::World> world_of(const std::filesystem::path& file, const record::Record& record) {
    scene::Scene scene = scene_in(file, record);
    const nlohmann::json object = record.header.value("object", nlohmann::json::object());
    const std::string felt = object.is_object() ? object.value("hash", nlohmann::json()).dump() : "null";
    const std::filesystem::path written = scene.object.points;
    std::string words = "not there";
    for (const std::filesystem::path& points :
         {written, std::filesystem::absolute(file).parent_path() / written.filename(),
          std::filesystem::path(scene::MODELS_DIRECTORY) / written.filename()}) {
        std::error_code ignored;
        if (points.is_absolute() && !std::filesystem::is_regular_file(points, ignored)) continue;
        scene.object.points = points;
        try {
            auto world = scene::build(scene);
            if (felt == '"' + record::hash_text(world->object_hash) + '"') return world;
            words = "found in " + points.string() + " are other points";
        } catch (const std::runtime_error& error) {  // not there, or cannot be what was felt
            if (points.is_absolute()) words = error.what();
        }
    }
    refuse(file, "the points that were felt, " + written.string() + " (hash " + felt +
                     "), are needed beside the record: " + words);
}

view::Image picture_of(const view::Source& source, double at_s) {
    view::Offscreen offscreen(source);
    return offscreen.picture(source.frame_at(at_s), view::home_camera(source.body), PICTURE_SIZE,
                             {.supersample = 2});
}

int view(const ViewOptions& options) {
    const std::filesystem::path file = options.what;
    if (!options.screenshot.empty()) {
        const record::AsideFile can_be_written(options.screenshot);  // said before the work, not after it
    }
    std::vector<pal_tick> ticks;
    std::unique_ptr<scene::World> world;
    if (file.extension() == ".palrec") {
        record::Record record = record::read(file);
        world = world_of(file, record);
        ticks = std::move(record.ticks);
    } else if (file.extension() == ".toml") {
        world = scene::build(scene::load(file));
    } else {
        refuse(file, "a scene (.toml) or a record (.palrec) is expected");
    }
    Progress progress(options.quiet);
    const Prepared prepared = prepare(std::move(world), progress);
    const view::Source source = view_source(*prepared.world, *prepared.field, ticks);
    if (!options.screenshot.empty()) {
        const double at_s = options.at_s >= 0.0 ? options.at_s : peak_time_s(ticks);
        record::write_file(options.screenshot, view::png_bytes(picture_of(source, at_s)));
        if (!options.quiet) std::cerr << "written: " << options.screenshot << '\n';
        return 0;
    }
    return view::show(source, view::WindowOptions{});
}

}  // namespace

void add_view(CLI::App& palpate, std::function<int()>& chosen) {
    auto options = std::make_shared<ViewOptions>();
    CLI::App* command = palpate.add_subcommand("view", "look at a scene, or at what a run felt");
    command->add_option("what", options->what, "scene file (.toml) or record (.palrec)")->required();
    command->add_option("--screenshot", options->screenshot, "write this PNG instead of opening a window");
    command
        ->add_option("--at", options->at_s, "scene time of the screenshot, s; the largest force by default")
        ->check(CLI::NonNegativeNumber);
    command->add_flag("--quiet", options->quiet, "no progress");
    command->footer("Example:\n  palpate view out/bunny/run.palrec --screenshot touch.png --at 3");
    command->callback([options, &chosen] { chosen = [options] { return view(*options); }; });
}

}  // namespace palpate::app
