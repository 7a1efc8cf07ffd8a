// What the viewer shows of a run, against the run's own ticks; and `palpate view` of records that moved.
#include "host/app/view_source.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "host/app/run.hpp"
#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate;
using namespace palpate::test;
using Catch::Matchers::Contains;
using Eigen::Vector3f;

namespace {

/// The 2 s of the soft sheet, in memory.
struct Run {
    app::Prepared prepared;
    app::RunResult result;
    view::Source source;
    Run() {
        const Folder folder;
        app::Progress quiet(true);
        prepared = app::prepare(scene::build(sheet_scene(folder.path())), quiet);
        result = app::run_virtual(prepared, {}, quiet);
        source = app::view_source(*prepared.world, *prepared.field, result.ticks);
    }
    [[nodiscard]] const pal_tick& tick(std::uint32_t path_tick) const {
        const auto found = std::find_if(result.ticks.begin(), result.ticks.end(),
                                        [&](const pal_tick& t) { return t.path_tick == path_tick; });
        REQUIRE(found != result.ticks.end());
        return *found;
    }
};

const Run& sheet_run() {
    static const Run run;
    return run;
}

Vector3f vec(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

const view::Moved& deepest(const view::Frame& frame) {
    return *std::max_element(
        frame.dip.begin(), frame.dip.end(),
        [](const view::Moved& a, const view::Moved& b) { return a.by_m.norm() < b.by_m.norm(); });
}

/// Files of a run of the sheet in `folder`/result, started as people do.
void run_sheet(const Folder& folder, const std::string& scene) {
    const Outcome ran =
        call(PAL_PALPATE_PROGRAM, {"run", scene, "--quiet", "--out", (folder / "result").string()}, folder);
    INFO(ran.err);
    REQUIRE(ran.code == 0);
}

Outcome draw(const Folder& folder, const std::filesystem::path& record, const std::string& picture) {
    return call(PAL_PALPATE_PROGRAM,
                {"view", record.string(), "--quiet", "--screenshot", picture, "--at", "1.1"}, folder);
}

std::size_t n_lines(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("a pressed moment has a dip as deep as the tool, below it, along the normal") {
    const Run& run = sheet_run();
    const std::uint32_t at = GENERATE(as<std::uint32_t>{}, 600, 1100, 1700);  // within 0.1 mm of a scan point
    const pal_tick& tick = run.tick(at);
    REQUIRE(tick.depth_m > 0.5e-3F);
    const view::Frame frame = run.source.frame_at(1e-3 * at);
    REQUIRE_FALSE(frame.dip.empty());
    // The dip is drawn from 33 nodes, not extrapolated: 2.5 % too soft here. Encoder and motor steps: 1 %.
    const view::Moved& most = deepest(frame);
    CHECK(most.by_m.norm() == Approx(tick.depth_m).epsilon(0.05));
    CHECK(frame.depth_m == tick.depth_m);
    const Vector3f place_m = run.source.body.points_m.at(most.point);
    CHECK((place_m.head<2>() - frame.tool_m.head<2>()).norm() <
          0.71e-3F);  // the nearest point of a 1 mm grid
    for (const view::Moved& move : frame.dip) {
        REQUIRE(move.point < run.source.body.points_m.size());
        CHECK(move.by_m.head<2>().norm() < 1e-6F);  // the sheet is flat: only z
        // A plate on a foundation rises beyond the dip: exp(-pi) of the depth on an infinite strip.
        CHECK(move.by_m.z() < 0.05F * tick.depth_m);
    }
}

TEST_CASE("a frame is its tick's: place, force as the motors made it, stiffness, time") {
    const Run& run = sheet_run();
    const std::uint32_t at = GENERATE(as<std::uint32_t>{}, 450, 600, 999, 1100, 1700);
    const pal_tick& tick = run.tick(at);
    const view::Frame frame = run.source.frame_at(1e-3 * at);
    REQUIRE(tick.truth_valid != 0);
    CHECK(frame.t_s == Approx(1e-3 * at));
    CHECK(frame.tool_m == vec(tick.position_m));  // position_scale 1
    CHECK(frame.force_n == vec(tick.truth_force_n));
    CHECK(frame.k_n_per_m == tick.k_n_per_m);
    // Hooke: motors and encoders are coarse (0.4 % each), and a tick is answered with the place before it.
    CHECK(frame.force_n.z() == Approx(frame.k_n_per_m * frame.depth_m).epsilon(0.02));
    CHECK(frame.rate_line ==
          "haptics 1000 Hz   missed 0   table " + std::to_string(tick.table_age_ticks) + " ms old");
}

TEST_CASE("the proxy rests on the undeformed skin below the tool") {
    const Run& run = sheet_run();
    for (const double t_s : {0.6, 1.1, 1.7}) {
        const view::Frame frame = run.source.frame_at(t_s);
        REQUIRE(frame.proxy_m.has_value());
        REQUIRE(frame.normal.has_value());
        // The sheet is z = 0, its skin smooth to a micrometre.
        CHECK(frame.proxy_m->z() == Approx(frame.tool_radius_m).margin(1e-6));
        CHECK((frame.proxy_m->head<2>() - frame.tool_m.head<2>()).norm() < 1e-5F);
        CHECK(frame.normal->z() == Approx(1.0).margin(1e-6));
        CHECK(frame.proxy_m->z() - frame.tool_m.z() == Approx(frame.depth_m).margin(1e-5));
    }
}

TEST_CASE("in the air there is no dip, no force, no depth and no contact") {
    const Run& run = sheet_run();
    for (const std::uint32_t at : {100U, 1900U}) {
        REQUIRE_FALSE(run.tick(at).depth_m > 0.0F);
        const view::Frame frame = run.source.frame_at(1e-3 * at);
        CHECK(frame.dip.empty());
        CHECK_FALSE(frame.proxy_m.has_value());
        CHECK_FALSE(frame.normal.has_value());
        CHECK(frame.force_n.norm() == 0.0F);
        CHECK(frame.depth_m == 0.0F);
        CHECK(frame.k_n_per_m == 0.0F);
    }
}

TEST_CASE("the picture is of the largest force in contact, and times beyond the run are its ends") {
    const Run& run = sheet_run();
    const double peak_s = app::peak_time_s(run.result.ticks);
    const float peak_n = vec(run.tick(static_cast<std::uint32_t>(std::lround(1e3 * peak_s))).force_n).norm();
    CHECK(peak_n > 0.5F);
    for (const pal_tick& tick : run.result.ticks) {
        if (tick.depth_m > 0.0F) CHECK(vec(tick.force_n).norm() <= peak_n);
    }
    CHECK(run.source.frame_at(99.0).t_s == run.source.duration_s);
    CHECK(run.source.frame_at(-1.0).t_s == 0.0);
    CHECK(app::peak_time_s({}) == 0.0);
}

TEST_CASE("the body's colours are the stiffness felt, where it was solved") {
    const Run& run = sheet_run();
    const view::Frame frame = run.source.frame_at(1.1);
    const view::Body& body = run.source.body;
    CHECK(body.stiffness_n_per_m.at(deepest(frame).point) == Approx(frame.k_n_per_m).epsilon(0.01));
    CHECK(std::isnan(body.stiffness_n_per_m.front()));  // a corner, which the path does not reach
    CHECK_THAT(body.unknown, Contains("not solved"));
}

TEST_CASE("a scene without a run shows its tool where the path begins, untouched skin and no force") {
    const Run& run = sheet_run();
    const view::Source source = app::view_source(*run.prepared.world, *run.prepared.field, {});
    const view::Frame frame = source.frame_at(0.7);
    CHECK(source.duration_s == 0.0);
    CHECK(frame.dip.empty());
    CHECK(frame.force_n.norm() == 0.0F);
    // The path begins 4 mm above the sheet at x = -3 mm, the tool's centre a radius higher.
    CHECK((frame.tool_m - Vector3f(-0.003F, 0.0F, 0.007F)).norm() < 1e-4F);
}

TEST_CASE("a record is shown with its own scene, whatever lies beside it", "[objects]") {
    const Folder folder;
    run_sheet(folder, write_sheet(folder.path()));
    const std::filesystem::path elsewhere = folder / "elsewhere";
    std::filesystem::create_directories(elsewhere);
    std::filesystem::copy_file(folder / "result" / "run.palrec", elsewhere / "run.palrec");
    const Outcome alone = draw(folder, elsewhere / "run.palrec", (folder / "alone.png").string());
    INFO(alone.err);
    REQUIRE(alone.code == 0);
    // A scene of the same points, ten times as hard and with another title, and one that cannot be read.
    std::string foreign = sheet_toml();
    foreign.replace(foreign.find("0.4e6"), 5, "4.0e6");
    foreign.replace(foreign.find("A soft sheet"), 12, "Not this one");
    for (const std::string& text : {foreign, std::string("scene = ?\n")}) {
        write_text(elsewhere / "scene.toml", text);
        write_text(elsewhere / "sheet.ply", "ply\n");
        const Outcome beside = draw(folder, elsewhere / "run.palrec", (folder / "beside.png").string());
        INFO(beside.err);
        REQUIRE(beside.code == 0);
        CHECK(text_of(folder / "beside.png") == text_of(folder / "alone.png"));
    }
}

TEST_CASE("a record finds points that moved along with it, and refuses others", "[objects]") {
    const Folder folder;
    std::filesystem::create_directories(folder / "a");
    std::filesystem::create_directories(folder / "b");
    run_sheet(folder, write_sheet(folder / "a"));
    std::filesystem::rename(folder / "result" / "run.palrec", folder / "b" / "run.palrec");
    std::filesystem::rename(folder / "a" / "sheet.ply", folder / "b" / "sheet.ply");
    const std::string picture = (folder / "x.png").string();
    const Outcome moved = draw(folder, folder / "b" / "run.palrec", picture);
    INFO(moved.err);
    CHECK(moved.code == 0);
    CHECK(std::filesystem::exists(picture));
    std::filesystem::remove(picture);

    std::string other = sheet_ply();
    other.replace(other.find("-0.0200 -0.0200 0\n"), 17, "-0.0200 -0.0201 0");
    write_text(folder / "b" / "sheet.ply", other);
    const Outcome wrong = draw(folder, folder / "b" / "run.palrec", picture);
    CHECK(wrong.code == 2);
    CHECK_THAT(wrong.err,
               Contains("run.palrec: the points that were felt, ") && Contains("are other points"));
    CHECK(n_lines(wrong.err) == 1);

    std::filesystem::remove(folder / "b" / "sheet.ply");
    const Outcome gone = draw(folder, folder / "b" / "run.palrec", picture);
    CHECK(gone.code == 2);
    CHECK_THAT(gone.err, Contains("are needed beside the record: not there"));
    CHECK(n_lines(gone.err) == 1);
    CHECK_FALSE(std::filesystem::exists(picture));
}

TEST_CASE("a picture that cannot be written is one line and exit 2, and an earlier picture stays",
          "[objects]") {
    const Folder folder;
    const std::string scene = write_sheet(folder.path());
    const std::string nowhere = (folder.path() / "no" / "such" / "x.png").string();
    const Outcome unwritable = draw(folder, scene, nowhere);
    CHECK(unwritable.code == 2);
    CHECK(unwritable.err == "palpate: " + nowhere + ": cannot be written (No such file or directory)\n");
    std::filesystem::create_directories(folder / "taken.png");
    const Outcome taken = draw(folder, scene, (folder / "taken.png").string());
    CHECK(taken.code == 2);
    CHECK(n_lines(taken.err) == 1);

    write_text(folder / "earlier.png", "an earlier picture");
    std::filesystem::create_directories(folder / "earlier.png.partial");  // the place aside is taken
    CHECK(draw(folder, scene, (folder / "earlier.png").string()).code == 2);
    CHECK(text_of(folder / "earlier.png") == "an earlier picture");
    std::filesystem::remove(folder / "earlier.png.partial");
    const Outcome drew = draw(folder, scene, (folder / "earlier.png").string());
    INFO(drew.err);
    CHECK(drew.code == 0);
    CHECK(text_of(folder / "earlier.png").substr(1, 3) == "PNG");
    CHECK_FALSE(std::filesystem::exists(folder / "earlier.png.partial"));
}
