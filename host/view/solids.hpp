/// The three solids that pictures are made of besides the cloud.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/view/gl.hpp"

namespace palpate::view {

enum class Solid { sphere, cylinder, cone };

/// Unit solids: the sphere of radius 1 around the origin; cylinder and cone of radius 1 from z = 0 to z = 1.
class Solids {
public:
    Solids();
    void draw(Solid solid) const;

private:
    struct Part {
        int first;
        int n_vertices;
    };
    gl::Vertices vertices_;
    Part sphere_{};
    Part cylinder_{};
    Part cone_{};
};

/// Model matrices.
[[nodiscard]] Eigen::Matrix4f ball(const Eigen::Vector3f& centre_m, float radius_m);
/// Takes the unit cylinder or cone to the one of `radius_m` between two points.
[[nodiscard]] Eigen::Matrix4f rod(const Eigen::Vector3f& from_m, const Eigen::Vector3f& to_m, float radius_m);

}  // namespace palpate::view
