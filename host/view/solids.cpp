#include "host/view/solids.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace palpate::view {
namespace {

constexpr int kAround = 32;
constexpr int kUp = 16;

struct Corner {
    Eigen::Vector3f at;
    Eigen::Vector3f normal;
};
static_assert(sizeof(Corner) == 6 * sizeof(float), "the vertex layout below");

float turn(int i) {
    return 2.0F * std::numbers::pi_v<float> * static_cast<float>(i) / kAround;
}

void add_quad(std::vector<Corner>& out, const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
    out.insert(out.end(), {a, b, c, a, c, d});
}

Corner on_sphere(int i, int j) {
    const float polar = std::numbers::pi_v<float> * static_cast<float>(j) / kUp;
    const Eigen::Vector3f at{std::sin(polar) * std::cos(turn(i)), std::sin(polar) * std::sin(turn(i)),
                             -std::cos(polar)};
    return {at, at};
}

/// A strip between z = 0 and z = 1 whose upper end has radius `top`, and the disc that closes its lower end.
void add_tube(std::vector<Corner>& out, float top) {
    for (int i = 0; i < kAround; ++i) {
        const Eigen::Vector3f a{std::cos(turn(i)), std::sin(turn(i)), 0.0F};
        const Eigen::Vector3f b{std::cos(turn(i + 1)), std::sin(turn(i + 1)), 0.0F};
        const Eigen::Vector3f up = Eigen::Vector3f::UnitZ();
        const Eigen::Vector3f lean = (1.0F - top) * up;
        add_quad(out, {a, a + lean}, {b, b + lean}, {top * b + up, b + lean}, {top * a + up, a + lean});
        out.insert(out.end(), {{Eigen::Vector3f::Zero(), -up}, {b, -up}, {a, -up}});
        if (top > 0.0F) out.insert(out.end(), {{up, up}, {top * a + up, up}, {top * b + up, up}});
    }
}

}  // namespace

Solids::Solids() {
    std::vector<Corner> all;
    for (int j = 0; j < kUp; ++j) {
        for (int i = 0; i < kAround; ++i) {
            add_quad(all, on_sphere(i, j), on_sphere(i + 1, j), on_sphere(i + 1, j + 1), on_sphere(i, j + 1));
        }
    }
    sphere_ = {0, static_cast<int>(all.size())};
    add_tube(all, 1.0F);
    cylinder_ = {sphere_.n_vertices, static_cast<int>(all.size()) - sphere_.n_vertices};
    add_tube(all, 0.0F);
    cone_ = {cylinder_.first + cylinder_.n_vertices, 0};
    cone_.n_vertices = static_cast<int>(all.size()) - cone_.first;
    vertices_.upload(all.data(), all.size() * sizeof(Corner));
    vertices_.attribute(0, 3, 6, 0);
    vertices_.attribute(1, 3, 6, 3);
}

void Solids::draw(Solid solid) const {
    const Part& part = solid == Solid::sphere ? sphere_ : solid == Solid::cylinder ? cylinder_ : cone_;
    vertices_.bind();
    glDrawArrays(GL_TRIANGLES, part.first, part.n_vertices);
}

Eigen::Matrix4f ball(const Eigen::Vector3f& centre_m, float radius_m) {
    Eigen::Affine3f model = Eigen::Affine3f::Identity();
    model.translate(centre_m).scale(radius_m);
    return model.matrix();
}

Eigen::Matrix4f rod(const Eigen::Vector3f& from_m, const Eigen::Vector3f& to_m, float radius_m) {
    const Eigen::Vector3f along_m = to_m - from_m;
    const float length_m = std::max(along_m.norm(), 1.0e-9F);
    const Eigen::Vector3f axis = along_m / length_m;
    const Eigen::Vector3f side = axis.unitOrthogonal();
    Eigen::Matrix4f model = Eigen::Matrix4f::Identity();
    model.block<3, 1>(0, 0) = radius_m * side;
    model.block<3, 1>(0, 1) = radius_m * axis.cross(side);
    model.block<3, 1>(0, 2) = length_m * axis;
    model.block<3, 1>(0, 3) = from_m;
    return model;
}

}  // namespace palpate::view
