#include "host/view/section.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/host/view/sheet.hpp"

using namespace palpate::view;
using namespace palpate::view::testing;

namespace {

constexpr float kDepth_m = 0.002F;
constexpr float kDipWidth_m = 0.0035F;  // of pressed(): a Gaussian
constexpr float kDomeRadius_m = 0.06F;  // of domed_sheet()

const Eigen::Vector3f kRight{1.0F, 0.0F, 0.0F};

}  // namespace

TEST_CASE("a cut through a pressed dome shows the dome, and the dip with its depth and width") {
    const Body body = domed_sheet();
    const Frame frame = pressed(body, 0.0F, 0.0F, kDepth_m);
    const auto section = section_of(body, frame, kRight);
    REQUIRE(section.has_value());
    REQUIRE(section->rest_m.size() > 100);
    REQUIRE(section->dipped_m.size() == section->rest_m.size());
    for (std::size_t i = 0; i < section->rest_m.size(); ++i) {
        const float x = section->rest_m[i].x();
        const float dome = std::sqrt(kDomeRadius_m * kDomeRadius_m - x * x) - kDomeRadius_m;
        CHECK(section->rest_m[i].y() == Approx(dome).margin(1e-5));
        // A quadratic over some points 0.8 mm apart rounds the tip of a Gaussian off by 2 %.
        const float d2 = x * x + dome * dome;
        const float dip = kDepth_m * std::exp(-d2 / (2.0F * kDipWidth_m * kDipWidth_m));
        CHECK(section->rest_m[i].y() - section->dipped_m[i].y() == Approx(dip).margin(0.02F * kDepth_m));
    }
    // The tool stands in the dip: its lowest point is at the bottom.
    CHECK(section->tool_m.x() == Approx(0.0).margin(1e-6));
    CHECK(section->tool_m.y() == Approx(frame.tool_radius_m - kDepth_m).margin(1e-6));
}

TEST_CASE("without a dip the cut is undeformed skin, without a normal there is none") {
    const Body body = domed_sheet(60);
    Frame frame = pressed(body, 0.0F, 0.0F, 0.0F);
    const auto section = section_of(body, frame, kRight);
    REQUIRE(section.has_value());
    CHECK(section->rest_m == section->dipped_m);
    frame.normal.reset();
    CHECK_FALSE(section_of(body, frame, kRight).has_value());
}

TEST_CASE("a thin object's other wall is not in the cut, and skin that ends, ends there") {
    Body body = domed_sheet(100);
    const std::size_t n = body.points_m.size();
    for (std::size_t i = 0; i < n; ++i) {
        body.points_m.emplace_back(body.points_m[i] - 0.001F * body.normals[i]);
        body.normals.emplace_back(-body.normals[i]);
        body.stiffness_n_per_m.push_back(body.stiffness_n_per_m[i]);
    }
    const auto section = section_of(body, pressed(body, 0.038F, 0.0F, 0.0F), kRight);
    REQUIRE(section.has_value());
    CHECK(section->rest_m.back().x() < 0.5F * section->half_width_m);            // 2 mm to the edge
    for (const Eigen::Vector2f& at : section->rest_m) CHECK(at.y() > -0.0008F);  // dome over 9 mm: -0.7 mm
}

TEST_CASE("a right that lies along the normal, and an empty body, are no trouble") {
    const Body body = domed_sheet(60);
    const Frame frame = pressed(body, 0.0F, 0.0F, kDepth_m);
    CHECK(section_of(body, frame, *frame.normal)->rest_m.size() > 100);
    CHECK(section_of(Body{}, frame, kRight)->rest_m.empty());
}
