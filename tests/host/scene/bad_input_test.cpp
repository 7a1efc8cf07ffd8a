#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "host/scene/scene.hpp"

using namespace palpate;

namespace {

const std::string GOOD = R"(scene = 1
[object]
points = "a.ply"
length_unit = "mm"
[skin]
young_pa = 1e5
thickness_m = 0.002
)";  // seven lines

/// What is said about `text`, without the file's name: "6: skin.young_pa ...".
std::string said(const std::string& text) {
    try {
        static_cast<void>(scene::parse(text, "s.toml"));
    } catch (const scene::Error& error) {
        const std::string words = error.what();
        CHECK(words.find('\n') == std::string::npos);
        REQUIRE(words.substr(0, 7) == "s.toml:");
        return words.substr(7);
    }
    return "nothing";
}

std::string without(const std::string& line) {
    std::string text = GOOD;
    return text.erase(text.find(line), line.size() + 1);
}

std::string with(const std::string& line, const std::string& instead) {
    std::string text = GOOD;
    return text.replace(text.find(line), line.size(), instead);
}

}  // namespace

TEST_CASE("a good scene is accepted") {
    CHECK(said(GOOD) == "nothing");
}

TEST_CASE("a missing key is named with its section's line and an example") {
    CHECK(said(without("points = \"a.ply\"")) ==
          "2: object.points is missing; a string is expected, such as \"bunny.obj\"");
    CHECK(said(without("young_pa = 1e5")) ==
          "5: skin.young_pa is missing; a number in Pa is expected, such as 0.4e6");
    CHECK(said(without("thickness_m = 0.002")) ==
          "5: skin.thickness_m is missing; a number in m is expected, such as 0.0015");
    CHECK(said(without("length_unit = \"mm\"")) ==
          "2: object.length_unit is missing; m, cm, mm, um or inch is expected, or size_m");
    CHECK(said(with("length_unit = \"mm\"", "size_m = 0.2")) == "nothing");
    CHECK(said("") == "1: object.points is missing; a string is expected, such as \"bunny.obj\"");
    CHECK(said("[[change]]\nfactor = 2\n[object]\npoints=\"a\"\nsize_m=1\n[skin]\n"
               "young_pa=1\nthickness_m=1") ==
          "1: change[0].shape is missing; nodule or gradient is expected, such as \"nodule\"");
    CHECK(
        said(GOOD + "[[change]]\nshape = \"nodule\"\nfactor = 2\n") ==
        "8: change[0].at_m is missing; three numbers in m are expected, such as [-0.0468, 0.0580, -0.0388]");
    CHECK(said(GOOD + "[hand]\npath = [\n{ t_s = 0, at_m = [0, 0, 0] }]\n") ==
          "10: hand.path[0].depth_m is missing; a number in m is expected, such as 0.006");
    CHECK(said(GOOD + "[hand]\ngrip = { mass_kg = 0.1, stiffness_n_per_m = 3 }\n") ==
          "9: hand.grip.damping_n_s_per_m is missing; a number in N s/m is expected, such as 8.0");
}

TEST_CASE("a value of the wrong type is named with its own line, its type and the right one") {
    CHECK(said(with("1e5", "\"soft\"")) ==
          "6: skin.young_pa is a string; a number in Pa is expected, such as 0.4e6");
    CHECK(said(with("\"a.ply\"", "3")) ==
          "3: object.points is an integer; a string is expected, such as \"bunny.obj\"");
    CHECK(said(GOOD + "[run]\nseed = 1.5\n") ==
          "9: run.seed is a number; a whole number is expected, such as 1");
    CHECK(said(GOOD + "[run]\nclock = true\n") ==
          "9: run.clock is a boolean; virtual or real is expected, such as \"virtual\"");
    CHECK(said(GOOD + "[placement]\nat_m = 3\n") ==
          "9: placement.at_m is an integer; three numbers in m are expected, such as [0.0, 0.0, 0.0]");
    CHECK(said(GOOD + "[placement]\nat_m = [1, 2]\n") ==
          "9: placement.at_m has 2 values; three numbers in m are expected, such as [0.0, 0.0, 0.0]");
    CHECK(said(GOOD + "[placement]\nat_m = [\n1,\n2,\n\"x\"]\n") ==
          "12: placement.at_m[2] is a string; three numbers in m are expected, such as [0.0, 0.0, 0.0]");
    CHECK(said(with("[object]", "columns = 3\n[object]")).substr(0, 10) == "2: columns");
    CHECK(said(with("points", "columns = \"x\"\npoints")) ==
          "3: object.columns is a string; an array of strings is expected, such as []");
    CHECK(said(GOOD + "[hand]\ngrip = 3\n") ==
          "9: hand.grip is an integer; none, light, firm or a table is expected, such as \"firm\"");
    CHECK(said(GOOD + "[hand]\npath = 3\n").substr(0, 52) ==
          "9: hand.path is an integer; an array of tables is ex");
    CHECK(said(GOOD + "[hand]\npath = [\n3]\n").substr(0, 53) ==
          "10: hand.path[0] is an integer; a table is expected, ");
    CHECK(said(GOOD + "[change]\nfactor = 3\n") == "8: change is a table; tables [[change]] are expected");
    CHECK(said(GOOD + "[[skin.x]]\n").substr(0, 9) == "8: skin.x");
    CHECK(said("skin = 3\n") == "1: skin is an integer; a section [skin] is expected");
    CHECK(said(GOOD + "[run]\nclock = 1979-05-27\n").substr(0, 31) == "9: run.clock is a date or time;");
}

TEST_CASE("an unknown key is refused and the nearest known one named") {
    const auto nearest = [](const std::string& text) {
        const std::string words = said(text);
        return words.substr(0, words.find(' ')) + " " + words.substr(words.find_last_of(' ') + 1);
    };
    CHECK(said(with("young_pa", "yuong_pa")) ==
          "6: skin.yuong_pa is unknown; the nearest known key is skin.young_pa");
    CHECK(nearest(with("thickness_m", "thicknes")) == "7: skin.thickness_m");
    CHECK(nearest("[skinn]\n") == "1: skin");
    CHECK(nearest("young_pa = 3\n") == "1: skin.young_pa");
    CHECK(nearest(GOOD + "[touch]\nforce_max = 3\n") == "9: touch.force_max_n");
    CHECK(nearest(GOOD + "[[change]]\nshape = \"nodule\"\nat_m = [0, 0, 0]\nradius = 3\n") ==
          "11: change.radius_m");
    CHECK(nearest(GOOD + "[hand]\npath = [{ t = 3 }]\n") == "9: hand.path.t_s");
    CHECK(nearest(GOOD + "[hand]\ngrip = { mass_k = 3 }\n") == "9: hand.grip.mass_kg");
    for (const char* later :
         {"include = []", "[map]", "[[layer]]", "[[inclusion]]", "[touch]\nfriction = [0, 0]",
          "[touch]\ndamping_n_s_per_m = 1", "[touch]\npassivity = \"off\"", "[hand]\nmotion = \"a\"",
          "[device]\nfaults = []", "[skin]\nthrough_thickness = true",
          "[patch]\nrigidity_sampling = \"linear\""}) {
        INFO(later);
        CHECK(said(std::string(later) + "\n").find(" is unknown; the nearest known key is ") !=
              std::string::npos);
    }
    CHECK(said("\"a\\nb\" = 1\n").substr(0, 17) == "1: a b is unknown");  // one line, whatever the name
    CHECK(said("b = 1\na = 1\n").substr(0, 4) == "1: b");                 // the first in the file
    CHECK(said(GOOD + "[[change]]\nshape = \"nodule\"\nat_m = [0, 0, 0]\nfactor = 2\nto_m = [0, 0, 1]\n") ==
          "12: change[0].to_m does not belong here; shape, at_m, radius_m, edge_m or factor would");
}

TEST_CASE("a number outside its range is refused with the range") {
    CHECK(said(with("1e5", "-1e5")) ==
          "6: skin.young_pa is -100000; a number in Pa above 0 and at most 1e+12 is expected, such as 0.4e6");
    const auto refused = [](const std::string& section, const std::string& line) {
        INFO(line);
        const std::string name = section + "." + line.substr(0, line.find(' '));
        const std::string words = said(GOOD + (section == "skin" ? "" : "[" + section + "]\n") + line + "\n");
        const std::string at = section == "skin" ? "8: " : "9: ";
        CHECK(words.substr(0, at.size() + name.size() + 4) == at + name + " is ");
        CHECK(words.find(" expected") != std::string::npos);
    };
    refused("skin", "poisson = 0.5");
    refused("skin", "poisson = -1");
    refused("skin", "foundation_n_per_m3 = -1");
    refused("skin", "foundation_n_per_m3 = inf");
    refused("touch", "tool_radius_m = 0");
    refused("touch", "force_max_n = 0");
    refused("touch", "force_max_n = 8.91");
    refused("touch", "force_max_n = nan");
    refused("touch", "ramp_s = -1");
    refused("patch", "size_m = 0");
    refused("solver", "tolerance = 0");
    refused("solver", "table_nodes = 3");
    refused("solver", "table_nodes = 32");
    refused("solver", "table_nodes = 67");
    refused("solver", "table_nodes = -5");
    refused("solver", "delay_ticks = 4294967297");
    refused("run", "duration_s = -1");
    refused("run", "seed = -1");
    for (const char* scale : {"position_scale", "force_scale"}) {
        for (const char* value : {" = 0", " = -1", " = 1001", " = nan"})
            refused("placement", std::string(scale) + value);
    }
    CHECK(said(with("0.002", "0")).substr(0, 24) == "7: skin.thickness_m is 0");
    CHECK(said(with("1e5", "0")).substr(0, 21) == "6: skin.young_pa is 0");
    CHECK(said(with("length_unit = \"mm\"", "size_m = -1")).substr(0, 22) == "4: object.size_m is -1");
    CHECK(said(GOOD + "[touch]\nforce_max_n = 8.9\n[solver]\ntable_nodes = 65\n") == "nothing");
    CHECK(said(GOOD + "[touch]\nforce_max_n = 1e-9\nramp_s = 60\n") == "nothing");
    CHECK(said(GOOD + "[placement]\nposition_scale = 2\nforce_scale = 0.5\n") == "nothing");
}

TEST_CASE("a change that cannot be is refused") {
    const std::string nodule = GOOD + "[[change]]\nshape = \"nodule\"\nat_m = [0, 0, 0]\nfactor = 2\n";
    CHECK(said(nodule) == "nothing");
    CHECK(said(nodule + "edge_m = 0.013\n") ==
          "12: change[0].edge_m is 0.013; at most twice radius_m, 0.012, is expected");
    CHECK(said(nodule + "radius_m = 0.0005\n") ==
          "8: change[0].edge_m is 0.002; at most twice radius_m, 0.001, is expected");  // a default
    CHECK(said(nodule + "radius_m = -1\n").substr(0, 28) == "12: change[0].radius_m is -1");
    CHECK(said(nodule + "edge_m = 0\n").substr(0, 25) == "12: change[0].edge_m is 0");
    CHECK(said(GOOD +
               "[[change]]\nshape = \"gradient\"\nfrom_m = [1, 0, 0]\nto_m = [1, 0, 0]\nfactor = [1, 2]\n") ==
          "11: change[0].to_m is the same point as from_m; another one is expected");
    CHECK(said(GOOD + "[[change]]\nshape = \"gradient\"\nfrom_m = [0, 0, 0]\nto_m = [1e-200, 0, 0]\nfactor = "
                      "[1, 2]\n") ==
          "11: change[0].to_m is the same point as from_m; another one is expected");
    CHECK_THAT(
        said(GOOD +
             "[[change]]\nshape = \"gradient\"\nfrom_m = [0, 0, 0]\nto_m = [0, 1e9, 0]\nfactor = [1, 2]\n"),
        Catch::Matchers::Contains("change[0].to_m") && Catch::Matchers::Contains("at most 1000"));
    CHECK(said(GOOD +
               "[[change]]\nshape = \"gradient\"\nfrom_m = [1, 0, 0]\nto_m = [0, 0, 0]\nfactor = [1, 0]\n") ==
          "12: change[0].factor[1] is 0; two numbers above 0 and at most 1000000 are expected, such as [0.8, "
          "1.2]");
}

TEST_CASE("what is not built yet is refused by name") {
    CHECK(said(GOOD + "depth_law = \"auto\"\n") ==
          "8: skin.depth_law = \"auto\" is not built yet: use linear");
    CHECK(said(GOOD + "[touch]\nlaw = \"paper\"\n") ==
          "9: touch.law = \"paper\" is not built yet: use potential or normal");
    CHECK(said(GOOD + "[patch]\nedges = \"free\"\n") ==
          "9: patch.edges = \"free\" is not built yet: use clamped");
    CHECK(said(GOOD + "[[change]]\nshape = \"hyperbola\"\n") ==
          "9: change[0].shape = \"hyperbola\" is not built yet: use nodule or gradient");
    CHECK(said(GOOD + "[touch]\nlaw = \"friendly\"\n") ==
          "9: touch.law is \"friendly\"; potential or normal is expected, such as \"potential\"");
}

TEST_CASE("columns are refused for files that name their own") {
    CHECK(said(with("\"a.ply\"", "\"a.PLY\"\ncolumns = [\"x_m\", \"y_m\", \"z_m\"]")) ==
          "4: object.columns is for XYZ and CSV; a PLY or OBJ file names its own columns: leave it out");
    CHECK(said(with("\"a.ply\"", "\"a.obj\"\ncolumns = []")) == "nothing");
    CHECK(said(with("\"a.ply\"", "\"\"")).substr(0, 25) == "3: object.points is empty");
}

TEST_CASE("a path's times increase") {
    const auto path = [](const std::string& a, const std::string& b) {
        const std::string rest = ", at_m = [0, 0, 0], depth_m = 0 },\n";
        return GOOD + "[hand]\npath = [\n{ t_s = " + a + rest + "{ t_s = " + b + rest + "]\n";
    };
    CHECK(said(path("0", "1")) == "nothing");
    CHECK(said(path("1", "1")) ==
          "11: hand.path[1].t_s is 1; more than the 1 before it is expected: times increase");
    CHECK(said(path("2", "1.5")).substr(0, 29) == "11: hand.path[1].t_s is 1.5; ");
    CHECK(said(path("-1", "1")).substr(0, 28) == "10: hand.path[0].t_s is -1; ");
}

TEST_CASE("a format that is newer is refused before anything else") {
    CHECK(said("scene = 2\nfrobnicate = true\n") ==
          "1: scene = 2 is newer than this program reads; scene = 1 is expected");
    CHECK(said("scene = 0\n") == "1: scene is 0; scene = 1 is expected");
    CHECK(said("scene = \"1\"\n") == "1: scene is a string; the format's number is expected: scene = 1");
    CHECK(said(without("scene = 1")) == "nothing");
}

TEST_CASE("a condition that does not read is refused") {
    const std::string words = "; \"<= X\", \">= X\" or \"== X\" is expected, such as \"<= 0.03\"";
    CHECK(said(GOOD + "[expect]\na = \"< 3\"\n") == "9: expect.a does not read as a condition" + words);
    CHECK(said(GOOD + "[expect]\na = \"<=\"\n") == "9: expect.a does not read as a condition" + words);
    CHECK(said(GOOD + "[expect]\na = \"\"\n") == "9: expect.a does not read as a condition" + words);
    CHECK(said(GOOD + "[expect]\na = 3\n") == "9: expect.a is an integer" + words);
    CHECK(said(GOOD + "[expect]\na = \"<= none\"\n") ==
          "9: expect.a compares with \"none\"; a number is expected after <=");
    CHECK(said(GOOD + "[expect]\n\"a b\" = \"<= 3\"\n").substr(0, 20) == "9: expect.a b cannot");
    CHECK(said(GOOD + "[expect]\na = \">=3\"\nb = \"== word\"\n") == "nothing");
}

TEST_CASE("text that is not TOML is refused at its line") {
    CHECK(said("scene = 1\n[object\n").substr(0, 3) == "2: ");
    CHECK(said("scene = 1\n\ntitle = \"a\n").substr(0, 3) == "3: ");
    CHECK(said("scene = 1\nscene = 1\n").substr(0, 3) == "2: ");
    CHECK(said("scene = 1\ntitle = \"\xff\"\n").substr(0, 3) == "2: ");
    CHECK(said(std::string(100000, '[')).substr(0, 3) == "1: ");
    CHECK(said("title = \"a\\nb\"\n" + GOOD) == "1: title holds a control character; plain text is expected");
}

TEST_CASE("a scene cut anywhere is refused or read as what is left of it, never a crash") {
    std::ifstream in(PAL_BUNNY_SCENE);
    const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    int refused = 0;
    for (std::size_t n = 0; n < text.size(); ++n) {
        try {
            const scene::Scene left = scene::parse(text.substr(0, n), "cut.toml");
            const std::string written = scene::resolved_toml(left, ".");
            CHECK(scene::resolved_toml(scene::parse(written, "cut.toml"), ".") == written);
        } catch (const scene::Error&) {
            ++refused;
        }
    }
    CHECK(refused > 1000);
}

TEST_CASE("a file that cannot be read is named with the reason") {
    const std::filesystem::path folder = PAL_TEST_FOLDER;
    CHECK_THROWS_WITH(
        scene::load(folder / "none.toml"),
        (folder / "none.toml").string() +
            ": cannot be read (No such file or directory); a scene file is expected, such as bunny.toml");
    CHECK_THROWS_WITH(scene::load(folder),
                      folder.string() + ": is a directory; a scene file is expected, such as bunny.toml");
}

TEST_CASE("a device on the USB wants the real clock, and what belongs to it wants the device") {
    CHECK(said(GOOD + "[device]\nbackend = \"usb\"\n") ==
          "9: device.backend is usb and run.clock is virtual; run.clock = \"real\" is expected: no person "
          "moves in lockstep");
    CHECK(said(GOOD + "[device]\nserial = \"A1\"\n") ==
          "9: device.serial is given; device.backend = \"usb\" is expected with it");
    CHECK(said(GOOD + "[device]\nmodel = \"my.toml\"\n") ==
          "9: device.model is given; device.backend = \"usb\" is expected with it");
}
