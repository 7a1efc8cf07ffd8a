#include "firmware/core/trig.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

TEST_CASE("sine and cosine are good to 1e-7 over +-4 rad and 2e-7 over the whole range") {
    double worst_near = 0.0;
    double worst_far = 0.0;
    for (int i = -2000000; i <= 2000000; ++i) {
        const float near_rad = static_cast<float>(i * 2.0e-6);
        const float far_rad = static_cast<float>(i * 5.0e-4);
        worst_near = std::fmax(worst_near, std::fabs(static_cast<double>(pal_sin(near_rad)) -
                                                     std::sin(static_cast<double>(near_rad))));
        worst_near = std::fmax(worst_near, std::fabs(static_cast<double>(pal_cos(near_rad)) -
                                                     std::cos(static_cast<double>(near_rad))));
        worst_far = std::fmax(worst_far, std::fabs(static_cast<double>(pal_sin(far_rad)) -
                                                   std::sin(static_cast<double>(far_rad))));
        worst_far = std::fmax(worst_far, std::fabs(static_cast<double>(pal_cos(far_rad)) -
                                                   std::cos(static_cast<double>(far_rad))));
    }
    CHECK(worst_near < 1.0e-7);
    CHECK(worst_far < 2.0e-7);
}

TEST_CASE("the arc tangent is good to 3e-7 all the way round, whatever the radius") {
    double worst = 0.0;
    for (int i = -2000000; i <= 2000000; ++i) {
        const double angle = i * 1.5707e-6;
        const double radius = i % 3 == 0 ? 1.0e-12 : i % 3 == 1 ? 1.0 : 1.0e12;
        const float y = static_cast<float>(radius * std::sin(angle));
        const float x = static_cast<float>(radius * std::cos(angle));
        worst = std::fmax(worst, std::fabs(static_cast<double>(pal_atan2(y, x)) -
                                           std::atan2(static_cast<double>(y), static_cast<double>(x))));
    }
    CHECK(worst < 3.0e-7);
}

TEST_CASE("the axes and the origin have their angles") {
    CHECK(pal_atan2(0.0F, 0.0F) == 0.0F);
    CHECK(pal_atan2(0.0F, 1.0F) == 0.0F);
    CHECK(std::fabs(pal_atan2(1.0F, 0.0F) - 1.57079633F) < 2.0e-7F);
    CHECK(std::fabs(pal_atan2(-1.0F, 0.0F) + 1.57079633F) < 2.0e-7F);
    CHECK(std::fabs(pal_atan2(0.0F, -1.0F) - 3.14159265F) < 3.0e-7F);
    CHECK(pal_sin(0.0F) == 0.0F);
    CHECK(pal_cos(0.0F) == 1.0F);
}

TEST_CASE("what is no angle gives NaN, not a number") {
    const float bad =
        GENERATE(as<float>{}, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                 -std::numeric_limits<float>::infinity());
    CHECK(std::isnan(pal_sin(bad)));
    CHECK(std::isnan(pal_cos(bad)));
    CHECK(std::isnan(pal_atan2(bad, 1.0F)));
    CHECK(std::isnan(pal_atan2(1.0F, bad)));
    CHECK(std::isnan(pal_sin(1.0e6F)));
}
