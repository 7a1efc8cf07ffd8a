// Everything that a person can get wrong: exit 2, one line that says where, what, and what would be right;
// stdout empty, an earlier result as it was, nothing left behind.
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;

namespace {

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    REQUIRE(at != std::string::npos);
    return text.replace(at, what.size(), with);
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

TEST_CASE("a path beyond the workspace is refused with axis and excess", "[bad]") {
    CHECK_THAT(
        said_of_scene("[touch]", "[placement]\nat_m = [0.2, 0.0, 0.0]\n[touch]"),
        Contains("sheet.toml:") && Contains("hand.path[0]") && Contains(" mm beyond the workspace along +x"));
    CHECK_THAT(said_of_scene("[touch]", "[placement]\nat_m = [0.0, -0.2, 0.0]\n[touch]"),
               Contains(" mm beyond the workspace along -y"));
}

TEST_CASE("a patch larger than the object is refused with both sizes", "[bad]") {
    CHECK_THAT(said_of_scene("[touch]", "[patch]\nsize_m = 0.1\n[touch]"),
               Contains("sheet.toml:") && Contains("100.0 mm") && Contains("56.6 mm"));
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
    CHECK_THAT(Refused(folder, {"--device", "usb"}).outcome.err, Contains("usb"));
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
}
#endif

TEST_CASE("a result takes the place of an earlier one, which is kept beside it", "[bad]") {
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
