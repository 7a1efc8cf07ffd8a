#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "host/app/commands.hpp"
#include "host/app/progress.hpp"
#include "host/app/run.hpp"
#include "host/app/view_source.hpp"
#include "host/record/record.hpp"
#include "host/view/offscreen.hpp"
#include "host/view/window.hpp"

namespace palpate::app {
namespace {

struct ViewOptions {
    std::string what, screenshot;
    double at_s = -1.0;
    bool quiet = false;
};

/// A record carries its scene as text; next to it lies the scene.toml that says the same.
scene::Scene scene_of(const std::filesystem::path& file, const record::Record& record) {
    const std::filesystem::path beside = file.parent_path() / "scene.toml";
    if (std::filesystem::exists(beside)) return scene::load(beside);
    return scene::parse(record.header.at("scene").get<std::string>(), file);
}

int view(const ViewOptions& options) {
    const std::filesystem::path file = options.what;
    std::vector<pal_tick> ticks;
    scene::Scene scene;
    if (file.extension() == ".palrec") {
        record::Record record = record::read(file);
        scene = scene_of(file, record);
        ticks = std::move(record.ticks);
    } else {
        scene = scene::load(file);
    }
    Progress progress(options.quiet);
    const Prepared prepared = prepare(scene::build(scene), progress);
    const view::Source source = view_source(*prepared.world, *prepared.field, ticks);
    if (!options.screenshot.empty()) {
        const double at_s = options.at_s >= 0.0 ? options.at_s : peak_time_s(ticks);
        view::screenshot(source, at_s, view::home_camera(source.body), 1280, 720, options.screenshot);
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
