// What the demo falls back to, and the picture of a record.
#include <catch2/catch.hpp>

#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;

TEST_CASE("the paper's ellipsoid takes the bunny's place, is named, and passes", "[objects]") {
    const Folder folder;
    REQUIRE(call(PAL_ELLIPSOID_PROGRAM, {(folder / "ellipsoid.ply").string()}, folder).code == 0);
    const Outcome outcome = call(
        PAL_PALPATE_PROGRAM,
        {"run", PAL_SCENES "/ellipsoid.toml", "--set", "object.points=" + (folder / "ellipsoid.ply").string(),
         "--json", "--out", (folder / "result").string()},
        folder);
    INFO(outcome.err);
    CHECK(outcome.code == 0);
    const nlohmann::json summary = json_of(folder / "result" / "summary.json");
    CHECK(nlohmann::json::parse(outcome.out) == summary);
    CHECK(summary["verdict"] == "pass");
    CHECK(summary["object"]["name"] == "ellipsoid.ply");
    CHECK(summary["object"]["n_points"] == 40000);
    CHECK(summary["stiffness_ratio"] >= 1.5);
}

#ifdef PALPATE_HAS_VIEW
namespace {

/// A big-endian word of a PNG's header.
std::uint32_t word_at(const std::string& png, std::size_t at) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i) word = word << 8 | static_cast<unsigned char>(png.at(at + i));
    return word;
}

}  // namespace

TEST_CASE("a record becomes a picture without a display", "[objects]") {
    const Folder folder;
    const std::string result = (folder / "result").string();
    const Outcome ran =
        call(PAL_PALPATE_PROGRAM, {"run", write_sheet(folder.path()), "--out", result}, folder);
    INFO(ran.err);
    REQUIRE(ran.code == 0);
    const std::string picture = (folder / "x.png").string();
    const Outcome drew = call(PAL_PALPATE_PROGRAM,
                              {"view", result + "/run.palrec", "--screenshot", picture, "--at", "1"}, folder);
    INFO(drew.err);
    CHECK(drew.code == 0);
    const std::string png = text_of(picture);
    REQUIRE(png.size() > 24);
    CHECK(png.substr(1, 3) == "PNG");
    CHECK(word_at(png, 16) == 1280);
    CHECK(word_at(png, 20) == 720);
}

TEST_CASE("a record that is not one is refused, and no picture is written", "[objects]") {
    const Folder folder;
    write_text(folder / "run.palrec", "not a record\n");
    const std::string picture = (folder / "x.png").string();
    const Outcome drew = call(PAL_PALPATE_PROGRAM,
                              {"view", (folder / "run.palrec").string(), "--screenshot", picture}, folder);
    CHECK(drew.code == 2);
    CHECK_THAT(drew.err, Contains("run.palrec: "));
    CHECK_FALSE(std::filesystem::exists(picture));
}
#endif
