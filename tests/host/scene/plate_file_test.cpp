#include "host/scene/plate_file.hpp"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <vector>

#include "host/scene/nearest.hpp"
#include "host/scene/plate_keys.hpp"
#include "host/scene/scene.hpp"

using namespace palpate;
using scene::PlateFile;

namespace {

const std::string GOOD = R"([plate]
size_m = [0.04, 0.03]
poisson = 0.3
[rigidity]
value_n_m = 0.03
)";  // five lines

std::string text_in(const std::string& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

PlateFile parsed(const std::string& text, const std::vector<std::string>& set = {}) {
    return scene::parse_plate(text, "p.toml", set);
}

/// What is said about `text`, without the file's name: "3: plate.poisson ...".
std::string said(const std::string& text, const std::vector<std::string>& set = {}) {
    try {
        static_cast<void>(parsed(text, set));
    } catch (const scene::Error& error) {
        const std::string words = error.what();
        CHECK(words.find('\n') == std::string::npos);
        return words.starts_with("p.toml:") ? words.substr(7) : words;
    }
    return "nothing";
}

std::string with(const std::string& line, const std::string& instead) {
    std::string text = GOOD;
    return text.replace(text.find(line), line.size(), instead);
}

}  // namespace

TEST_CASE("the smallest plate file has the defaults of the reference") {
    const PlateFile file = parsed(GOOD);
    CHECK(file.plate.size_m == scene::Vec2{0.04, 0.03});
    CHECK(file.plate.nodes == std::array<Eigen::Index, 2>{65, 65});
    CHECK(file.plate.edges ==
          std::array{plate::Edge::clamped, plate::Edge::clamped, plate::Edge::clamped, plate::Edge::clamped});
    CHECK(file.plate.foundation_n_per_m3 == 0.0);
    CHECK(file.rigidity.values_n_m.size() == 1);
    CHECK(file.rigidity.values_n_m(0, 0) == 0.03);
    CHECK(file.load.at_m == scene::Vec2{0.02, 0.015});
    CHECK(file.load.force_n == 1.0);
    CHECK(file.load.radius_m == 0.0);
    CHECK(file.solver.method == plate::Method::automatic);
    CHECK(file.solver.tolerance == 1e-3);
    CHECK(file.solver.extrapolate);
    CHECK(file.output.points_m.empty());
    CHECK(file.output.field.empty());
    CHECK(file.output.plot.empty());
}

TEST_CASE("every key of a plate file is read") {
    const PlateFile file = parsed(R"(
[plate]
size_m = [1, 2.0]
nodes = [33, 129]
poisson = -0.2
thickness_m = 0.002
edges = ["free", "clamped", "supported", "free"]
foundation_n_per_m3 = 1e6
curvature_per_m = [20.0, -5]
[rigidity]
file = "d.npy"
sampling = "nearest"
[load]
at_m = [0.25, 0.5]
force_n = 3
radius_m = 0.1
[solver]
method = "damped-jacobi"
tolerance = 0.01
extrapolate = false
[output]
points_m = [[0, 0], [1.0, 2.0]]
field = "w.NPY"
plot = "a/w.png"
)");
    using plate::Edge;
    CHECK(file.plate.size_m == scene::Vec2{1.0, 2.0});
    CHECK(file.plate.nodes == std::array<Eigen::Index, 2>{33, 129});
    CHECK(file.plate.poisson == -0.2);
    CHECK(file.plate.thickness_m == 0.002);
    CHECK(file.plate.edges == std::array{Edge::free, Edge::clamped, Edge::supported, Edge::free});
    CHECK(file.plate.foundation_n_per_m3 == 1e6);
    CHECK(file.plate.curvature_per_m == scene::Vec2{20.0, -5.0});
    CHECK(file.rigidity.file == "d.npy");
    CHECK(file.rigidity.sampling == plate::Sampling::nearest);
    CHECK(file.load.at_m == scene::Vec2{0.25, 0.5});
    CHECK(file.load.force_n == 3.0);
    CHECK(file.load.radius_m == 0.1);
    CHECK(file.solver.method == plate::Method::damped_jacobi);
    CHECK(file.solver.tolerance == 0.01);
    CHECK_FALSE(file.solver.extrapolate);
    CHECK(file.output.points_m == std::vector<scene::Vec2>{{0.0, 0.0}, {1.0, 2.0}});
    CHECK(file.output.field == "w.NPY");
    CHECK(file.output.plot == "a/w.png");
    for (const scene::PlateKey& key : scene::plate_keys()) {
        INFO(key.name);
        CHECK((file.places.contains(key.name) || std::string(key.name) == "rigidity.value_n_m"));
    }
}

TEST_CASE("each method of the solver has its word") {
    std::set<plate::Method> methods;
    for (const char* word : {"auto", "cholesky", "multigrid", "closed-form", "bounds", "eigen", "jacobi",
                             "damped-jacobi", "eq7"}) {
        const plate::Method method = parsed(GOOD, {std::string("solver.method=") + word}).solver.method;
        CHECK(plate::name_of(method) == std::string(word));
        methods.insert(method);
    }
    CHECK(methods.size() == 9);
}

TEST_CASE("an unknown key of a plate file is refused with its line and the nearest known one") {
    CHECK(said(with("poisson", "poison")) ==
          "3: plate.poison is unknown; the nearest known key is plate.poisson");
    CHECK(said("[plat]\n" + GOOD) == "1: plat is unknown; the nearest known key is plate");
    CHECK(said("force_n = 2\n" + GOOD) == "1: force_n is unknown; the nearest known key is load.force_n");
    CHECK(said(GOOD + "radius_m = 1\n") ==
          "6: rigidity.radius_m is unknown; the nearest known key is load.radius_m");
    CHECK(said(GOOD, {"solver.tolerence=1"}) ==
          "--set solver.tolerence: solver.tolerence is unknown; the nearest known key is solver.tolerance");
}

TEST_CASE("a missing key of a plate file is named with its section's line and an example") {
    CHECK(said("") ==
          "1: plate.size_m is missing; two numbers in m above 0 and at most 1000 are expected, "
          "such as [0.04, 0.04]");
    CHECK(said(with("poisson = 0.3\n", "")) ==
          "1: plate.poisson is missing; a number above -1 and below 0.5 is expected, such as 0.3");
    CHECK(
        said(with("value_n_m = 0.03", "")) ==
        "4: rigidity.value_n_m or rigidity.file is missing; a number in N m, such as 0.03, or a .csv or .npy "
        "file is expected");
}

TEST_CASE("a value of the wrong type or size is refused with its line and the right one") {
    CHECK(said(with("0.3\n", "\"soft\"\n")) ==
          "3: plate.poisson is a string; a number above -1 and below 0.5 is expected, such as 0.3");
    CHECK(said(with("0.3\n", "0.5\n")) ==
          "3: plate.poisson is 0.5; a number above -1 and below 0.5 is expected, such as 0.3");
    CHECK(said(with("0.3\n", "nan\n")) ==
          "3: plate.poisson is nan; a number above -1 and below 0.5 is expected, such as 0.3");
    CHECK(said(with("[0.04, 0.03]", "0.04")) ==
          "2: plate.size_m is a number; two numbers in m above 0 and at most 1000 are expected, such as "
          "[0.04, 0.04]");
    CHECK(said(with("[0.04, 0.03]", "[0.04]")) ==
          "2: plate.size_m has 1 value; two numbers in m above 0 and at most 1000 are expected, such as "
          "[0.04, 0.04]");
    CHECK(said(with("[0.04, 0.03]", "[0.04, -1]")) ==
          "2: plate.size_m[1] is -1; two numbers in m above 0 and at most 1000 are expected, such as "
          "[0.04, 0.04]");
    CHECK(said(with("0.03\n", "0\n")) ==
          "5: rigidity.value_n_m is 0; a number in N m above 0 and at most 1e+15 is expected, such "
          "as 0.03");
    CHECK(said(GOOD + "[solver]\nextrapolate = 1\n") ==
          "7: solver.extrapolate is an integer; true or false is expected, such as true");
    CHECK(said(GOOD + "[solver]\nmethod = \"magic\"\n") ==
          "7: solver.method is \"magic\"; auto, cholesky, multigrid, closed-form, bounds, eigen, jacobi, "
          "damped-jacobi or eq7 is expected, such as \"auto\"");
    CHECK(
        said(GOOD + "[output]\npoints_m = [[0, 0], [1]]\n") ==
        "7: output.points_m[1] has 1 value; an array of places in m at least 0 and at most 1000 is expected, "
        "such as [[0.01, 0.02], [0.03, 0.02]]");
    CHECK(said("plate = 3\n") == "1: plate is an integer; a section [plate] is expected");
    CHECK_THAT(said("[plate]\nsize_m = [1, 1\npoisson = 0.3\n"), Catch::Matchers::StartsWith("3: "));
}

TEST_CASE("edges are one word for all, or four") {
    const std::string words =
        "; clamped, supported or free, for all or for x low, x high, z low and z high, is expected, such as "
        "\"clamped\"";
    const auto file = [](const std::string& value) {
        return with("poisson = 0.3", "poisson = 0.3\nedges = " + value);
    };
    CHECK(parsed(file("\"free\"")).plate.edges[3] == plate::Edge::free);
    CHECK(said(file("\"glued\"")) == "4: plate.edges is \"glued\"" + words);
    CHECK(said(file("[\"free\", \"free\"]")) == "4: plate.edges has 2 values" + words);
    CHECK(said(file("[\"free\", \"free\", \"free\", 1]")) == "4: plate.edges[3] is an integer" + words);
}

TEST_CASE("node counts that cannot be extrapolated are refused with the nearest that can") {
    const auto nodes = [](const std::string& value) {
        return with("poisson = 0.3", "poisson = 0.3\nnodes = " + value);
    };
    const auto words = [](const std::string& is, const std::string& good) {
        return "4: plate.nodes" + is + "; 4 m + 1 from 9 is expected, such as " + good +
               ", or solver.extrapolate = false";
    };
    CHECK(said(nodes("[64, 65]")) == words("[0] is 64", "61 or 65"));
    CHECK(said(nodes("[67, 65]")) == words("[0] is 67", "65 or 69"));
    CHECK(said(nodes("[65, 66]")) == words("[1] is 66", "65 or 69"));
    CHECK(said(nodes("[5, 65]")) == words("[0] is 5", "9 or 13"));
    CHECK(said(nodes("[4096, 65]")) == words("[0] is 4096", "4093 or 4097"));
    CHECK(said(nodes("[9, 4097]")) == "nothing");
    CHECK(said(nodes("[64, 6]"), {"solver.extrapolate=false"}) == "nothing");
    CHECK(said(nodes("[65.0, 65]")).starts_with("4: plate.nodes[0] is a number; two whole numbers"));
    CHECK(said(nodes("[4, 65]")).starts_with("4: plate.nodes[0] is 4; two whole numbers at least 5"));
    CHECK(said(nodes("[4101, 65]")).starts_with("4: plate.nodes[0] is 4101; two whole numbers"));
}

TEST_CASE("what does not go together is refused with the line that is at fault") {
    CHECK(said(GOOD + "file = \"d.csv\"\n") ==
          "6: rigidity.file and rigidity.value_n_m are both given; one is expected");
    CHECK(said(with("value_n_m = 0.03", "file = \"d.txt\"")) ==
          "5: rigidity.file is \"d.txt\"; a .csv or .npy file is expected");
    CHECK(said(with("poisson = 0.3", "poisson = 0.3\ncurvature_per_m = [1, 0]")) ==
          "4: plate.curvature_per_m needs plate.thickness_m; a number in m is expected, such as 0.001");
    CHECK(said(with("poisson = 0.3", "poisson = 0.3\ncurvature_per_m = [0, 0]")) == "nothing");
    CHECK(said(GOOD + "[load]\nat_m = [0.01, 0.03]\n") ==
          "7: load.at_m[1] is 0.03, not inside the plate; between 0 and 0.03 is expected");
    CHECK(said(GOOD + "[load]\nforce_n = 2\nradius_m = 0.02\n") ==
          "8: load.radius_m is 0.02, a disc larger than the plate; below 0.015 is expected");
    CHECK(said(GOOD + "[load]\nradius_m = 0.01\nat_m = [0.005, 0.015]\n") ==
          "8: load.at_m[0] is 0.005 with load.radius_m 0.01, not inside the plate; between 0.01 and 0.03 is "
          "expected");
    CHECK(said(GOOD + "[output]\npoints_m = [[0.04, 0.03], [0.01, 0.031]]\n") ==
          "7: output.points_m[1][1] is 0.031, off the plate; at most 0.03 is expected");
    CHECK(said(GOOD + "[output]\nfield = \"w.txt\"\n") ==
          "7: output.field is \"w.txt\"; a .csv or .npy file is expected");
    CHECK(said(GOOD + "[output]\nplot = \"w.svg\"\n") ==
          "7: output.plot is \"w.svg\"; a .png file is expected");
    CHECK(said(GOOD + "[output]\nplot = \"a\\u0000.png\"\n").starts_with("7: output.plot holds a control"));
}

TEST_CASE("a --set of a plate file replaces a value, and is named where it is wrong") {
    CHECK(parsed(GOOD, {"rigidity.value_n_m=5", "load.at_m=[0.01, 0.02]"}).rigidity.values_n_m(0, 0) == 5.0);
    CHECK(said(GOOD, {"plate.poisson=1"}).starts_with("--set plate.poisson: plate.poisson is 1; "));
    CHECK(said(GOOD, {"nonsense"}) ==
          "--set nonsense: KEY=VALUE is expected, such as rigidity.value_n_m=0.03");
}

TEST_CASE("a rigidity that is no rigidity is named by its row and column") {
    Eigen::ArrayXXd values = Eigen::ArrayXXd::Constant(3, 5, 0.03);
    CHECK_NOTHROW(scene::check_rigidity(values, "d.csv"));
    const double bad = GENERATE(as<double>{}, 0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity());
    values(2, 4) = bad;
    values(1, 3) = bad;  // the first, row by row
    CHECK_THROWS_WITH(scene::check_rigidity(values, "d.csv"),
                      Catch::Matchers::StartsWith("d.csv: row 2, column 4 is " + scene::number_text(bad) +
                                                  "; a rigidity in N m above 0"));
}

TEST_CASE("a plate file finds its rigidity beside itself, CSV or NPY") {
    const std::filesystem::path folder = std::filesystem::path(PAL_TEST_FOLDER) / "plates";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "d.csv") << "1,2,3\n4,5,6\n";
    std::ofstream(folder / "p.toml") << with("value_n_m = 0.03", "file = \"d.csv\"");
    const PlateFile file = scene::load_plate(folder / "p.toml");
    CHECK(file.rigidity.values_n_m.rows() == 2);
    CHECK(file.rigidity.values_n_m(1, 0) == 4.0);
    std::ofstream(folder / "d.csv") << "1,2,3\n4,-5,6\n";
    CHECK_THROWS_WITH(scene::load_plate(folder / "p.toml"),
                      Catch::Matchers::Contains("d.csv: row 2, column 2 is -5; a rigidity in N m above 0"));
    std::filesystem::remove(folder / "d.csv");
    CHECK_THROWS_WITH(scene::load_plate(folder / "p.toml"),
                      Catch::Matchers::Contains("p.toml:5: ") && Catch::Matchers::Contains("No such file"));
    CHECK_THROWS_WITH(scene::load_plate(folder), Catch::Matchers::Contains("it is a directory"));
    CHECK_THROWS_WITH(scene::load_plate(folder / "none.toml"), Catch::Matchers::Contains("No such file"));
}

TEST_CASE("the example plates are accepted") {
    std::size_t n_files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(PAL_PLATES)) {
        if (entry.path().extension() != ".toml") continue;
        INFO(entry.path());
        CHECK_NOTHROW(scene::load_plate(entry.path()));
        ++n_files;
    }
    CHECK(n_files == 3);
}

TEST_CASE("the nearest name is the one with the fewest typing errors") {
    const std::vector<std::string> known{"load.at_m", "load.radius_m", "plate.nodes"};
    CHECK(scene::nearest_among("load.ta_m", known) == "load.at_m");
    CHECK(scene::nearest_among("load.raduis", known) == "load.radius_m");
    CHECK(scene::nearest_among("nodes", known) == "plate.nodes");
    CHECK(scene::nearest_among("x", {}).empty());
}

TEST_CASE("docs/PLATE_FILE.md is what the table of keys says") {
    CHECK(text_in(PAL_PLATE_MD) == scene::plate_markdown());
}

TEST_CASE("write docs/PLATE_FILE.md", "[.write-plate]") {
    std::ofstream(PAL_PLATE_MD) << scene::plate_markdown();
}
