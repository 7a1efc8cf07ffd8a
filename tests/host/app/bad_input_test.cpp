// Everything that a person can get wrong: exit 2, one line that says where, what, and what would be right;
// stdout empty, an earlier result as it was, nothing left behind.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;
using Catch::Matchers::Matches;
using Catch::Matchers::StartsWith;

namespace {

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    REQUIRE(at != std::string::npos);
    return text.replace(at, what.size(), with);
}

/// The sheet as the top of a ball of 40 mm, its highest point at the origin.
std::string dome_ply() {
    constexpr double RADIUS_M = 0.04;
    std::istringstream in(sheet_ply());
    std::string text, line;
    for (bool in_body = false; std::getline(in, line); in_body = in_body || line == "end_header") {
        std::array<double, 2> at{};
        if (in_body && std::sscanf(line.c_str(), "%lf %lf", &at[0], &at[1]) == 2) {
            const double height_m = std::sqrt(RADIUS_M * RADIUS_M - at[0] * at[0] - at[1] * at[1]) - RADIUS_M;
            line.resize(line.size() - 1);
            line += std::to_string(height_m);
        }
        text += line + "\n";
    }
    return text;
}

/// `palpate run` of what `folder` holds, with an earlier result in out/.
struct Refused {
    explicit Refused(const Folder& folder, std::vector<std::string> more = {}) {
        const std::filesystem::path earlier = folder / "out";
        if (!std::filesystem::exists(earlier)) {
            std::filesystem::create_directory(earlier);
            write_text(earlier / "summary.json", "{\"an\": \"earlier result\"}\n");
        }
        std::vector<std::string> arguments{"run", (folder / "sheet.toml").string(), "--out",
                                           earlier.string()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const auto before = files_below(earlier);
        outcome = call(PAL_PALPATE_PROGRAM, arguments, folder);
        INFO(outcome.err);
        CHECK(outcome.code == 2);
        CHECK(outcome.out.empty());
        CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
        CHECK(outcome.err.starts_with("palpate: "));
        CHECK(files_below(earlier) == before);
        CHECK_FALSE(std::filesystem::exists(folder / "out.partial"));
        CHECK_FALSE(std::filesystem::exists(folder / "out.1"));
        CHECK(scratch_in(folder).empty());
    }
    Outcome outcome;
};

/// The line about a changed scene, without "palpate: FOLDER/".
std::string said_of_scene(const std::string& what, const std::string& with) {
    const Folder folder;
    write_sheet(folder.path());
    write_text(folder / "sheet.toml", replaced(sheet_toml(), what, with));
    const std::string line = Refused(folder).outcome.err;
    const std::string begin = "palpate: " + (folder / "").string();
    INFO(line);
    REQUIRE(line.starts_with(begin));
    return line.substr(begin.size());
}

/// The same about a changed scan.
std::string said_of_scan(const std::string& ply) {
    const Folder folder;
    write_sheet(folder.path());
    write_text(folder / "sheet.ply", ply);
    const std::string line = Refused(folder).outcome.err;
    const std::string begin = "palpate: " + (folder / "").string();
    INFO(line);
    REQUIRE(line.starts_with(begin));
    return line.substr(begin.size());
}

}  // namespace

TEST_CASE("a missing scene is named", "[bad]") {
    const Folder folder;
    const std::string line = Refused(folder).outcome.err;
    CHECK_THAT(line, Contains((folder / "sheet.toml").string()));
    CHECK_THAT(line, Contains("No such file"));
}

TEST_CASE("a missing scan is named with the package that has it", "[bad]") {
    const std::string line =
        said_of_scene("points = \"sheet.ply\"", "points = \"bread.ply\"\npackage = \"bakery\"");
    CHECK_THAT(line, Contains("sheet.toml:4: "));
    CHECK_THAT(line, Contains("bread.ply"));
    CHECK_THAT(line, Contains("bakery"));
}

TEST_CASE("an empty and a truncated scan are refused with the place", "[bad]") {
    CHECK_THAT(said_of_scan(""), Contains("sheet.ply:1: ") && Contains("empty"));
    const std::string whole = sheet_ply();
    const std::size_t line_end = whole.find('\n', whole.size() / 2);
    const auto last_line = static_cast<std::size_t>(
        std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(line_end), '\n') + 1);
    CHECK_THAT(said_of_scan(whole.substr(0, line_end - 4)),
               Contains("sheet.ply:" + std::to_string(last_line) + ": ") && Contains("truncated"));
    CHECK_THAT(said_of_scan(whole.substr(0, line_end + 1)), Contains("1681") && Contains("truncated"));
}

TEST_CASE("a vertex that is not a number is refused with its line", "[bad]") {
    CHECK_THAT(said_of_scan(replaced(sheet_ply(), "-0.0200 -0.0200 0\n", "-0.0200 nan 0\n")),
               Contains("sheet.ply:8: "));
}

TEST_CASE("two points are no surface", "[bad]") {
    CHECK_THAT(said_of_scan("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                            "property float z\nend_header\n0 0 0\n0.01 0 0\n"),
               Contains("sheet.ply:3: ") && Contains("2 points"));
}

TEST_CASE("stiffness that is missing, negative or a word is refused with its line and what would be right",
          "[bad]") {
    CHECK_THAT(said_of_scene("young_pa = 0.4e6\n", ""),
               Contains("sheet.toml:6: skin.young_pa is missing") && Contains("Pa"));
    CHECK_THAT(said_of_scene("young_pa = 0.4e6", "young_pa = -0.4e6"),
               Contains("sheet.toml:8: skin.young_pa") && Contains("above 0"));
    CHECK_THAT(said_of_scene("young_pa = 0.4e6", "young_pa = \"soft\""),
               Contains("sheet.toml:8: skin.young_pa is a string") && Contains("a number in Pa is expected"));
}

TEST_CASE("an unknown key is refused with the nearest known one", "[bad]") {
    CHECK_THAT(said_of_scene("thickness_m = 0.0015", "thicknes_m = 0.0015"),
               Contains("sheet.toml:9: ") && Contains("thicknes_m") && Contains("thickness_m"));
}

TEST_CASE("a path beyond the workspace is refused with line, axis and excess", "[bad]") {
    CHECK_THAT(said_of_scene("[touch]", "[placement]\nat_m = [0.2, 0.0, 0.0]\n[touch]"),
               Matches(R"(sheet\.toml:18: hand\.path\[0\] at t_s = 0 is 147\.0 mm beyond the workspace )"
                       R"(along \+x \(limit 50\.0 mm\); move the object with \[placement\] .*\n)"));
    CHECK_THAT(said_of_scene("[touch]", "[placement]\nat_m = [0.0, -0.2, 0.0]\n[touch]"),
               Matches(R"(sheet\.toml:18: hand\.path\[0\] at t_s = 0 is 150\.0 mm beyond the workspace )"
                       R"(along -y \(limit -50\.0 mm\); .*\n)"));
}

TEST_CASE("a path that leaves the workspace only between its points is refused with its leg", "[bad]") {
    const Folder folder;
    write_sheet(folder.path());
    write_text(folder / "sheet.ply", dome_ply());
    const std::string path = "path = [\n";
    std::string scene = sheet_toml();
    scene.resize(scene.find(path) + path.size());
    scene +=
        "{ t_s = 0, at_m = [-0.018, 0, 0], depth_m = -0.004 },\n"
        "{ t_s = 2, at_m = [0.018, 0, 0], depth_m = -0.004 },\n]\n"
        "[placement]\nat_m = [0, 0, 0.0475]\n";
    write_text(folder / "sheet.toml", scene);
    CHECK_THAT(Refused(folder).outcome.err,
               Matches(R"(palpate: .*sheet\.toml:16: hand\.path\[0\] to \[1\] at t_s = 1 is 4\.5 mm beyond )"
                       R"(the workspace along \+z \(limit 50\.0 mm\); .*\n)"));
}

TEST_CASE("a patch larger than the object's longest side is refused with line and both sizes", "[bad]") {
    CHECK_THAT(
        said_of_scene("[touch]", "[patch]\nsize_m = 0.05\n[touch]"),
        Matches(R"(sheet\.toml:12: patch\.size_m = 50\.0 mm is larger than the object \(40\.0 mm along )"
                R"(its longest side\); make the patch smaller .*\n)"));
}

TEST_CASE("a change, a focus and a path off the scan are refused with their line", "[bad]") {
    CHECK_THAT(
        said_of_scene("[touch]", "[[change]]\nshape = \"nodule\"\nat_m = [0.05, 0, 0]\nfactor = 2\n[touch]"),
        Matches(R"(sheet\.toml:13: change\[0\]\.at_m: there is no smooth skin near this place; .*\n)"));
    CHECK_THAT(
        said_of_scene("[touch]", "[placement]\nfacing = \"operator\"\nfocus_m = [0.05, 0, 0]\n[touch]"),
        Matches(R"(sheet\.toml:13: placement\.focus_m: there is no smooth skin near this place; .*\n)"));
    CHECK_THAT(
        said_of_scene("at_m = [0.0030, 0.0, 0.0]", "at_m = [0.0300, 0.0, 0.0]"),
        Matches(R"(sheet\.toml:17: hand\.path\[1\] to \[2\] at t_s = \d\.\d+ has no smooth skin near it; )"
                R"(choose points on one face of the scan\n)"));
}

TEST_CASE("a --set that cannot be built is refused by its name", "[bad]") {
    const Folder folder;
    write_sheet(folder.path());
    CHECK_THAT(Refused(folder, {"--set", "patch.size_m=0.05"}).outcome.err,
               StartsWith("palpate: --set patch.size_m: patch.size_m = 50.0 mm is larger"));
    CHECK_THAT(Refused(folder, {"--set", "hand.path.3.depth_m=-0.06"}).outcome.err,
               StartsWith("palpate: --set hand.path[3].depth_m: hand.path[3] at t_s = 2 is 13.0 mm beyond"));
}

TEST_CASE("an output that cannot be written is refused before anything is solved", "[bad]") {
    const Folder folder;
    const std::string scene = write_sheet(folder.path());
    write_text(folder / "file", "precious\n");
    const std::string out = (folder / "file" / "below").string();
    const Outcome outcome = call(PAL_PALPATE_PROGRAM, {"run", scene, "--out", out}, folder);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    CHECK_THAT(outcome.err, Contains(out) && Contains("cannot be written") && Contains("--out"));
    CHECK(text_of(folder / "file") == "precious\n");
}

TEST_CASE("a bad --set is refused by its name", "[bad]") {
    const Folder folder;
    write_sheet(folder.path());
    CHECK_THAT(Refused(folder, {"--set", "skin.young=3"}).outcome.err,
               Contains("--set skin.young") && Contains("young_pa"));
    CHECK_THAT(Refused(folder, {"--set", "skin.young_pa=-3"}).outcome.err, Contains("--set skin.young_pa"));
    CHECK_THAT(Refused(folder, {"--set", "nonsense"}).outcome.err, Contains("--set nonsense"));
}

TEST_CASE("a bad option or argument is refused by its name", "[bad]") {
    const Folder folder;
    write_sheet(folder.path());
    CHECK_THAT(Refused(folder, {"--nonsense"}).outcome.err, Contains("--nonsense"));
    CHECK_THAT(Refused(folder, {"--clock", "sand"}).outcome.err, Contains("--clock") && Contains("sand"));
    CHECK_THAT(Refused(folder, {"--duration", "-1"}).outcome.err, Contains("--duration"));
    for (const char* number : {"nan", "inf", "0"})
        CHECK_THAT(Refused(folder, {"--duration", number}).outcome.err, Contains("--duration"));
    CHECK_THAT(Refused(folder, {"--device", "usb:12345678", "--firmware", "123"}).outcome.err,
               Contains("123: No such file"));
    CHECK_THAT(Refused(folder, {"--device", "usb", "--firmware", "/nowhere.bin"}).outcome.err,
               Contains("/nowhere.bin: No such file"));
    CHECK_THAT(Refused(folder, {"--device", "link"}).outcome.err,
               Contains("sim, usb or usb:SERIAL is expected, not link"));
    CHECK_THAT(Refused(folder, {"--check", "none"}).outcome.err, Contains("--check"));
    CHECK(call(PAL_PALPATE_PROGRAM, {}, folder).code == 2);
    CHECK(call(PAL_PALPATE_PROGRAM, {"sing"}, folder).code == 2);
    CHECK(call(PAL_PALPATE_PROGRAM, {"run"}, folder).code == 2);
}

#ifdef PALPATE_HAS_RIG
TEST_CASE("a rig that is not on this machine is refused", "[bad]") {
    const Folder folder;
    write_sheet(folder.path());
    CHECK_THAT(Refused(folder, {"--rig", "192.0.2.1:1502"}).outcome.err,
               Contains("192.0.2.1") && Contains("127.0.0"));
    CHECK_THAT(Refused(folder, {"--rig", "1502"}).outcome.err, Contains("1502"));
    CHECK_THAT(Refused(folder, {"--rig", ""}).outcome.err, Contains("is not ADDR:PORT"));
}
#endif

TEST_CASE("a result takes the place of an earlier one, which is kept beside it", "[real]") {
    const Folder folder;
    const std::string scene = write_sheet(folder.path());
    std::filesystem::create_directory(folder / "out");
    write_text(folder / "out" / "summary.json", "{}\n");
    const Outcome outcome = call(
        PAL_PALPATE_PROGRAM,
        {"run", scene, "--clock", "real", "--duration", "0.2", "--out", (folder / "out").string()}, folder);
    INFO(outcome.err);
    CHECK(outcome.code == 0);
    CHECK(text_of(folder / "out.1" / "summary.json") == "{}\n");
    CHECK(json_of(folder / "out" / "summary.json")["schema"] == "palpate.summary/1");
}

#ifdef PALPATE_HAS_VIEW
TEST_CASE("view says what it can look at", "[bad]") {
    const Folder folder;
    write_text(folder / "notes.txt", "hello\n");
    const Outcome outcome = call(PAL_PALPATE_PROGRAM, {"view", (folder / "notes.txt").string()}, folder);
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains("notes.txt: a scene (.toml) or a record (.palrec) is expected"));
}
#endif
