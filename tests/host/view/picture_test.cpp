/// Off-screen pictures, measured with what project() and the legend say about them.
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <limits>

#include "host/view/offscreen.hpp"
#include "host/view/overlay.hpp"
#include "tests/host/view/pixels.hpp"
#include "tests/host/view/sheet.hpp"

using namespace palpate::view;
using namespace palpate::view::testing;

namespace {

constexpr Size kSize{960, 540};

Camera side_view(const Body& body) {
    Camera camera = home_camera(body);
    camera.yaw_rad = 0.3F;
    camera.pitch_rad = 0.35F;
    return camera;
}

/// Box of `half` pixels around where `point_m` lands.
Box around(const Camera& camera, const Eigen::Vector3f& point_m, int half) {
    const auto p = project(camera, kSize, point_m);
    const int x = static_cast<int>(p->x);
    const int y = static_cast<int>(p->y);
    return {x - half, y - half, x + half, y + half};
}

struct FoundArrow {
    Eigen::Vector2f tip;
    float length_px;  ///< from the tool's centre
};

/// The red pixel farthest from the tool's centre. The label beside the tip is red too: it must not win, so
/// only pixels within 4 px of the line along the force count.
FoundArrow find_arrow(const Image& image, const Camera& camera, const Frame& frame) {
    const auto tool = project(camera, kSize, frame.tool_m);
    const auto ahead = project(camera, kSize, frame.tool_m + 0.001F * frame.force_n.normalized());
    const Eigen::Vector2f from(tool->x, tool->y);
    const Eigen::Vector2f along = (Eigen::Vector2f(ahead->x, ahead->y) - from).normalized();
    FoundArrow arrow{from, 0.0F};
    for (const auto& pixel : find(image, {0, 0, kSize.width, kSize.height}, is_force_red)) {
        const Eigen::Vector2f d = pixel - from;
        const float off = std::abs(d.x() * along.y() - d.y() * along.x());
        if (off < 4.0F && d.dot(along) > arrow.length_px) arrow = {pixel, d.dot(along)};
    }
    return arrow;
}

float projected_length_px(const Camera& camera, const Frame& frame, float metres_per_newton) {
    const auto tail = project(camera, kSize, frame.tool_m);
    const auto tip = project(camera, kSize, frame.tool_m + metres_per_newton * frame.force_n);
    return std::hypot(tip->x - tail->x, tip->y - tail->y);
}

}  // namespace

TEST_CASE("the force arrow starts at the tool, moves with it, and doubles with the force") {
    const Source source = stroke();
    const Camera camera = side_view(source.body);
    const float scale = arrow_scale(source.body);
    Offscreen offscreen(source);
    const Style style{.supersample = 2};
    std::vector<FoundArrow> found;
    for (const float x_m : {-0.008F, 0.004F}) {
        for (const float force_n : {1.5F, 3.0F}) {
            Frame frame = pressed(source.body, x_m, 0.0F, 0.003F);
            frame.force_n = force_n * frame.normal->normalized();
            frame.normal.reset();  // lies along the arrow
            const Image image = offscreen.picture(frame, camera, kSize, style);
            const FoundArrow arrow = find_arrow(image, camera, frame);
            const auto tip = project(camera, kSize, frame.tool_m + scale * frame.force_n);
            INFO("x " << x_m << " m, " << force_n << " N");
            // The last pixels of a cone's tip are thinner than a pixel.
            CHECK(arrow.tip.x() == Approx(tip->x).margin(5.0));
            CHECK(arrow.tip.y() == Approx(tip->y).margin(5.0));
            CHECK(arrow.length_px == Approx(projected_length_px(camera, frame, scale)).margin(5.0));
            found.push_back(arrow);
        }
    }
    CHECK(found[1].length_px / found[0].length_px == Approx(2.0).margin(0.15));
    CHECK(found[3].length_px / found[2].length_px == Approx(2.0).margin(0.15));
    CHECK(found[2].tip.x() - found[0].tip.x() > 60.0F);
}

TEST_CASE("without a force there is no arrow") {
    const Source source = stroke();
    const Camera camera = side_view(source.body);
    Offscreen offscreen(source);
    const Image image = offscreen.picture(pressed(source.body, 0, 0, 0), camera, kSize, {});
    CHECK(find(image, {0, 0, kSize.width, kSize.height}, is_force_red).empty());
}

TEST_CASE("a dip changes the picture at the contact and nowhere else, and a zero dip changes nothing") {
    const Source source = stroke();
    const Camera camera = side_view(source.body);
    Offscreen offscreen(source);
    Frame frame = pressed(source.body, -0.006F, 0.0F, 0.004F);
    const Eigen::Vector3f contact = *frame.proxy_m;
    const auto draw = [&](float dip_share) {
        Frame shown = frame;
        for (Moved& move : shown.dip) move.by_m *= dip_share;
        return offscreen.picture(shown, camera, kSize, {});
    };
    const Image flat = draw(0.0F);
    const Image dipped = draw(1.0F);
    const Box at_contact = around(camera, contact, 70);
    CHECK(n_different(flat, dipped, at_contact, 24) > 500);
    CHECK(n_different(flat, draw(0.0F), {0, 0, kSize.width, kSize.height}, 0) == 0);
    const Box far_off = around(camera, {0.012F, -0.002F, 0.012F}, 25);
    CHECK(n_different(flat, dipped, far_off, 4) == 0);
}

TEST_CASE("the dip is lit: the wall that faces away from the light is darker than any flat skin") {
    Source source = stroke();
    std::fill(source.body.stiffness_n_per_m.begin(), source.body.stiffness_n_per_m.end(), 700.0F);
    Camera camera = side_view(source.body);
    camera.pitch_rad = 1.2F;  // into the dip
    Offscreen offscreen(source);
    Frame frame = pressed(source.body, 0.0F, 0.0F, 0.004F);
    frame.tool_m = {0.0F, 0.05F, 0.0F};  // out of the way, with its shadow
    frame.proxy_m.reset();
    frame.normal.reset();
    frame.force_n.setZero();
    const Image dipped = offscreen.picture(frame, camera, kSize, {});
    frame.dip.clear();
    const Image flat = offscreen.picture(frame, camera, kSize, {});
    // Dots and lines of equal dip only brighten.
    const auto darkest = [&](const Image& image) {
        int low = 255;
        const Box box = around(camera, {0, 0, 0}, 60);
        for (int y = box.y0; y < box.y1; ++y) {
            for (int x = box.x0; x < box.x1; ++x) low = std::min<int>(low, image.at(x, y).g);
        }
        return low;
    };
    CHECK(darkest(flat) > 100);
    CHECK(darkest(dipped) < darkest(flat) - 25);
}

TEST_CASE("the colour bar says the smallest and largest stiffness and shows their colours at its ends") {
    const Source source = stroke();
    const auto legend = legend_of(source.body, kSize);
    REQUIRE(legend.has_value());
    float low = std::numeric_limits<float>::infinity();
    float high = -low;
    for (const float k : source.body.stiffness_n_per_m) {
        low = std::min(low, k);
        high = std::max(high, k);
    }
    CHECK(legend->min == low);
    CHECK(legend->max == high);
    CHECK(legend->unit == "N/m");
    CHECK_FALSE(legend->has_unknown);
    CHECK(legend->low == viridis().front());
    CHECK(legend->high == viridis().back());
    Offscreen offscreen(source);
    const Image image = offscreen.picture(source.frame_at(0.5), side_view(source.body), kSize, {});
    const int x = (legend->bar.x0 + legend->bar.x1) / 2;
    CHECK(image.at(x, legend->bar.y1 - 1) == legend->low);
    CHECK(image.at(x, legend->bar.y0) == legend->high);
    const Rgb middle = image.at(x, (legend->bar.y0 + legend->bar.y1) / 2);
    CHECK(std::abs(middle.g - viridis()[128].g) <= 2);
    CHECK_FALSE(image.at(x, legend->bar.y1 + 1) == legend->low);
}

TEST_CASE(
    "a point's colour follows its stiffness: the stiff spot is yellow, soft skin is not, unknown is grey") {
    Source source = stroke();
    Body& body = source.body;
    for (std::size_t i = 0; i < body.points_m.size(); ++i) {
        const Eigen::Vector3f d = body.points_m[i] - Eigen::Vector3f(-0.01F, 0, 0.004F);
        if (std::hypot(d.x(), d.z()) < 0.003F) {
            body.stiffness_n_per_m[i] = std::numeric_limits<float>::quiet_NaN();
        }
    }
    const Camera camera = side_view(body);
    Frame frame;
    frame.tool_m = {0, 0.05F, 0};
    Offscreen offscreen(source);
    const Image image = offscreen.picture(frame, camera, kSize, {});
    const auto at = [&](float x, float z) {
        const Eigen::Vector3f point(x, std::sqrt(0.0036F - x * x - z * z) - 0.06F, z);
        const auto p = project(camera, kSize, point);
        return image.at(static_cast<int>(p->x), static_cast<int>(p->y));
    };
    const Rgb stiff = at(0.009F, 0.0F);
    CHECK((stiff.r > 150 && stiff.g > 140 && stiff.b < 90));
    const Rgb soft = at(-0.004F, 0.012F);
    CHECK((soft.g < soft.r + 20 && soft.b > soft.g + 25));
    const Rgb unknown = at(-0.01F, 0.004F);
    CHECK(std::max({unknown.r, unknown.g, unknown.b}) - std::min({unknown.r, unknown.g, unknown.b}) <= 6);
    CHECK(unknown.g > 60);
    const auto legend = legend_of(body, kSize);
    REQUIRE(legend.has_value());
    CHECK(legend->has_unknown);
    CHECK(std::isfinite(legend->max));
    CHECK(image.at((legend->bar.x0 + legend->bar.x1) / 2, legend->bar.y1 + 36) == kUnknown);
}

TEST_CASE("skin at rest has nearly the colour that the bar has for its stiffness, wherever it faces") {
    const Source source = stroke();
    Body low = source.body;
    const float share = GENERATE(as<float>{}, 0.0F, 0.5F, 1.0F);
    for (float& k : low.stiffness_n_per_m) k = kSoft_n_per_m + share * (kStiff_n_per_m - kSoft_n_per_m);
    low.stiffness_n_per_m.front() = kSoft_n_per_m;  // two corners make the scale
    low.stiffness_n_per_m.back() = kStiff_n_per_m;
    // On its side, facing +x: the light does not reach it from every yaw.
    const auto on_its_side = [](const Eigen::Vector3f& v) { return Eigen::Vector3f(v.y(), -v.x(), v.z()); };
    for (Eigen::Vector3f& v : low.points_m) v = on_its_side(v);
    for (Eigen::Vector3f& v : low.normals) v = on_its_side(v);
    Source one = source;
    one.body = low;
    Offscreen offscreen(one);
    Frame frame;
    frame.tool_m = {0, 0.05F, 0};
    const Rgb bar = viridis()[static_cast<std::size_t>(std::lround(255.0F * share))];
    for (const float yaw_rad : {0.5F, 1.5F, 2.6F}) {
        Camera camera = side_view(low);
        camera.yaw_rad = yaw_rad;
        const Image image = offscreen.picture(frame, camera, kSize, {});
        for (const float x_m : {-0.012F, 0.0F, 0.012F}) {
            const float y_m = std::sqrt(0.0036F - x_m * x_m) - 0.06F;
            const auto at = project(camera, kSize, on_its_side({x_m, y_m, 0.0F}));
            const Rgb seen = image.at(static_cast<int>(at->x), static_cast<int>(at->y));
            INFO("yaw " << yaw_rad << ", x " << x_m);
            // Light and shade may take or give a sixth, and a highlight a little of white.
            CHECK(std::abs(seen.r - bar.r) <= bar.r / 6 + 12);
            CHECK(std::abs(seen.g - bar.g) <= bar.g / 6 + 12);
            CHECK(std::abs(seen.b - bar.b) <= bar.b / 6 + 12);
        }
    }
}

TEST_CASE("the picture has a cut through the contact that deepens with the dip") {
    const Source source = stroke();
    constexpr Size kLarge{1280, 720};
    Offscreen offscreen(source);
    const Box inset{132, 492, 432, 696};
    const auto is_skin = [](Rgb c) {
        const Rgb line = viridis()[48];
        return std::abs(c.r - line.r) + std::abs(c.g - line.g) + std::abs(c.b - line.b) < 30;
    };
    const auto lowest_px = [&](float depth_m) {
        const Image image =
            offscreen.picture(pressed(source.body, 0, 0, depth_m), side_view(source.body), kLarge, {});
        float lowest = 0.0F;
        for (const auto& pixel : find(image, inset, is_skin)) {
            if (std::abs(pixel.x() - 282.0F) < 20.0F) lowest = std::max(lowest, pixel.y());
        }
        return lowest;
    };
    const float px_per_m = 142.0F / 0.009F;  // half the inset's 300 px less its margin, half the cut's 18 mm
    CHECK(lowest_px(0.002F) - lowest_px(0.0F) == Approx(0.002F * px_per_m).margin(2.0));
    CHECK(lowest_px(0.003F) - lowest_px(0.0F) == Approx(0.003F * px_per_m).margin(2.5));
}

TEST_CASE("a body without any known stiffness has no colour bar and is grey") {
    Source source = stroke();
    for (float& k : source.body.stiffness_n_per_m) k = std::numeric_limits<float>::quiet_NaN();
    CHECK_FALSE(legend_of(source.body, kSize).has_value());
    Offscreen offscreen(source);
    CHECK_FALSE(offscreen.picture(source.frame_at(0), side_view(source.body), kSize, {}).rgb.empty());
}

TEST_CASE("the same moment gives the same bytes, in a new context too") {
    const Source source = stroke();
    const Camera camera = side_view(source.body);
    const auto folder = std::filesystem::temp_directory_path() / "palpate-view-test";
    std::filesystem::create_directories(folder);
    const auto bytes = [&](const char* name) {
        screenshot(source, 0.7, camera, 640, 360, folder / name);
        std::ifstream in(folder / name, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    const std::string first = bytes("first.png");
    const std::string second = bytes("second.png");
    CHECK(first.substr(1, 3) == "PNG");
    CHECK(first == second);
    CHECK_FALSE(std::filesystem::exists(folder / "first.png.part"));
    std::filesystem::remove_all(folder);
}

TEST_CASE("a picture that cannot be written is an error that names the file") {
    const Source source = stroke();
    const std::string file = "/nowhere/at/all.png";
    CHECK_THROWS_WITH(screenshot(source, 0, home_camera(source.body), 64, 48, file), Catch::Contains(file));
}

TEST_CASE("pictures of no size, of one pixel and of an empty body are no trouble") {
    Source source;
    source.frame_at = [](double) { return Frame{}; };
    Offscreen offscreen(source);
    const Camera camera = home_camera(source.body);
    CHECK(offscreen.picture(Frame{}, camera, {0, 0}, {}).rgb.empty());
    CHECK(offscreen.picture(Frame{}, camera, {0, 100}, {}).rgb.empty());
    CHECK(offscreen.picture(Frame{}, camera, {1, 1}, {}).rgb.size() == 3);
    CHECK(offscreen.picture(Frame{}, camera, {200, 100}, {}).rgb.size() == 60000);
}

TEST_CASE("an exaggerated dip is drawn deeper and said in the picture") {
    const Source source = stroke();
    const Camera camera = side_view(source.body);
    Offscreen offscreen(source);
    const Frame frame = pressed(source.body, 0, 0, 0.001F);
    const Image true_scale = offscreen.picture(frame, camera, kSize, {});
    const Image deeper = offscreen.picture(frame, camera, kSize, {.dip_scale = 4.0F});
    CHECK(n_different(true_scale, deeper, around(camera, {0, 0, 0}, 60), 24) > 300);
    // The words, in red, at the left below the key.
    const Box key{0, 60, 320, 330};
    CHECK(find(deeper, key, is_force_red).size() > find(true_scale, key, is_force_red).size() + 100);
}
