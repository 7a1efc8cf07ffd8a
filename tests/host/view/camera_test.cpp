#include "host/view/camera.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <limits>

#include "host/view/player.hpp"
#include "tests/host/view/sheet.hpp"

using namespace palpate::view;

TEST_CASE("the target is in the middle, x to the right, y upwards, z nearer") {
    Camera camera;
    camera.target_m = {0.01F, 0.02F, 0.03F};
    const Size size{640, 480};
    const auto at = [&](float dx, float dy, float dz) {
        return *project(camera, size, camera.target_m + Eigen::Vector3f(dx, dy, dz));
    };
    CHECK(at(0, 0, 0).x == Approx(320));
    CHECK(at(0, 0, 0).y == Approx(240));
    CHECK(at(0.01F, 0, 0).x > 321);
    CHECK(at(0, 0.01F, 0).y < 239);
    CHECK(at(0, 0, 0.01F).depth_m == Approx(camera.distance_m - 0.01F));
    CHECK_FALSE(project(camera, size, camera.target_m + Eigen::Vector3f(0, 0, 1)).has_value());
    CHECK_FALSE(project(camera, {0, 480}, camera.target_m).has_value());
}

TEST_CASE("a metre at the target is as many pixels as metres_per_pixel says") {
    Camera camera;
    camera.yaw_rad = 0.7F;
    camera.pitch_rad = 0.3F;
    const Size size{640, 480};
    const Eigen::Vector3f right = camera.view().block<1, 3>(0, 0).transpose();
    const auto pixel = project(camera, size, camera.target_m + 0.01F * right);
    CHECK((pixel->x - 320.0F) * metres_per_pixel(camera, size) == Approx(0.01F));
}

TEST_CASE("projection and OpenGL matrices put a point in the same place") {
    Camera camera;
    camera.yaw_rad = -0.4F;
    camera.pitch_rad = 0.6F;
    const Size size{800, 600};
    const Eigen::Vector3f point{0.012F, -0.02F, 0.031F};
    const Eigen::Vector4f clip =
        camera.projection(size, {0, 0, 0}, 0.1F) * camera.view() * point.homogeneous();
    const auto pixel = project(camera, size, point);
    CHECK((clip.x() / clip.w() * 0.5F + 0.5F) * 800.0F == Approx(pixel->x));
    CHECK((0.5F - clip.y() / clip.w() * 0.5F) * 600.0F == Approx(pixel->y));
    CHECK(std::abs(clip.z()) < clip.w());
}

TEST_CASE("dragging right turns the front of the object to the right, and pan carries the target along") {
    const Camera camera;
    const Size size{640, 480};
    const Eigen::Vector3f front = camera.target_m + Eigen::Vector3f(0, 0, 0.02F);
    CHECK(project(orbited(camera, 20, 0), size, front)->x > 321);
    CHECK(project(orbited(camera, 0, 20), size, front)->y > 241);
    const auto carried = project(panned(camera, 30, -12, size), size, camera.target_m);
    CHECK(carried->x == Approx(350));
    CHECK(carried->y == Approx(228));
    CHECK(zoomed(camera, 1).distance_m < camera.distance_m);
    CHECK(zoomed(zoomed(camera, 3), -3).distance_m == Approx(camera.distance_m));
    CHECK(orbited(camera, 0, 1e6F).pitch_rad < 1.5708F);
}

TEST_CASE("the first view sees the skin's outside at the focus, obliquely") {
    Body body;
    const Eigen::Vector3f normal = GENERATE(
        as<Eigen::Vector3f>{}, Eigen::Vector3f(0, 1, 0), Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(1, 0, 0),
        Eigen::Vector3f(-0.6F, 0.0F, -0.8F), Eigen::Vector3f(0.7F, 0.7F, 0.14F));
    for (int i = 0; i < 5; ++i) {
        body.points_m.emplace_back(0.001F * static_cast<float>(i), 0, 0);
        body.normals.push_back(normal.normalized());
        body.stiffness_n_per_m.push_back(500);
    }
    const Camera camera = home_camera(body);
    const Eigen::Vector3f to_eye = (camera.eye_m() - camera.target_m).normalized();
    CHECK(to_eye.dot(normal.normalized()) > 0.3F);
    CHECK(to_eye.dot(normal.normalized()) < 0.95F);
}

TEST_CASE("the first view goes round what stands before the skin") {
    Body body;
    const auto add = [&](float x, float y, float z, const Eigen::Vector3f& normal) {
        body.points_m.emplace_back(x, y, z);
        body.normals.push_back(normal);
        body.stiffness_n_per_m.push_back(500);
    };
    for (int i = -20; i <= 20; ++i) {
        for (int j = -20; j <= 20; ++j) {
            add(0.001F * static_cast<float>(i), 0.001F * static_cast<float>(j), 0, Eigen::Vector3f::UnitZ());
        }
    }
    const auto to_eye = [&] {
        const Camera camera = home_camera(body);
        return Eigen::Vector3f((camera.eye_m() - camera.target_m).normalized());
    };
    CHECK(to_eye().y() > 0.7F);        // upright skin: from above
    for (int i = -40; i <= 40; ++i) {  // a roof 2 cm above
        for (int j = 0; j <= 40; ++j) {
            add(0.001F * static_cast<float>(i), 0.02F, 0.001F * static_cast<float>(j),
                -Eigen::Vector3f::UnitY());
        }
    }
    CHECK(to_eye().y() < 0.5F);
    CHECK(to_eye().z() > 0.3F);
}

TEST_CASE("framing shows every point of the object") {
    const Body body = palpate::view::testing::domed_sheet(20);
    const Size size{640, 480};
    const Camera camera = framed(home_camera(body), body);
    for (const Eigen::Vector3f& point : body.points_m) {
        const auto pixel = project(camera, size, point);
        REQUIRE(pixel.has_value());
        CHECK((pixel->x > 0 && pixel->x < 640 && pixel->y > 0 && pixel->y < 480));
    }
}

TEST_CASE("the player stops at the end, starts over, and steps within the run") {
    Player player{.duration_s = 2.0, .t_s = 1.9, .speed = 1.0, .is_playing = true};
    player.advance(0.3);
    CHECK(player.t_s == 2.0);
    CHECK_FALSE(player.is_playing);
    player.toggle();
    CHECK(player.t_s == 0.0);
    CHECK(player.is_playing);
    player.step(-0.5);
    CHECK(player.t_s == 0.0);
    CHECK_FALSE(player.is_playing);
    player.step(0.25);
    player.advance(1.0);
    CHECK(player.t_s == 0.25);
    for (int i = 0; i < 20; ++i) player.faster();
    CHECK(player.speed == 16.0);
}
