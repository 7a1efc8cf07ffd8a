#include "host/chart/chart.hpp"

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>

namespace palpate::chart {
namespace {

constexpr double q_min = 0.2;                          // MATH.md eq. 1: beyond it is the far side
constexpr double cos_10_deg = 0.98480775301220805937;  // frame_at: x is too near e3
constexpr double half_pi = 1.57079632679489661923;
constexpr double sqrt2 = 1.41421356237309504880;

/// atan(t)/t, smooth at 0. Three halvings of the angle by square roots, then the series: the same bits with
/// every mathematical library.
double atan_ratio(double t) {
    double ratio = 1.0;
    for (int i = 0; i < 3; ++i) {
        const double f = 1.0 / (1.0 + std::sqrt(1.0 + t * t));
        ratio *= 2.0 * f;
        t *= f;
    }
    const double square = t * t;  // at most tan^2(pi/16) = 0.04: 13 terms reach 1e-19
    double sum = 0.0;
    for (int k = 12; k >= 0; --k) sum = 1.0 / (2.0 * k + 1.0) - square * sum;
    return ratio * sum;
}

/// tan(a)/a for |a| < pi/2, smooth at 0, from the series of sine and cosine.
double tan_ratio(double a) {
    const double square = a * a;
    double sine = 1.0;
    double cosine = 1.0;
    for (int k = 12; k >= 1; --k) {  // (pi/2)^26 / 26! = 3e-22
        cosine = 1.0 - square * cosine / ((2.0 * k - 1.0) * (2.0 * k));
        sine = 1.0 - square * sine / ((2.0 * k) * (2.0 * k + 1.0));
    }
    return sine / cosine;
}

}  // namespace

Eigen::Vector3d Frame::local_m(const Eigen::Vector3d& at_m) const {
    return axes * (at_m - origin_m);
}

Eigen::Vector3d Frame::world_m(const Eigen::Vector3d& local_m) const {
    return origin_m + axes.transpose() * local_m;
}

Frame frame_at(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& e3, double kappa_per_m) {
    assert(e3.squaredNorm() > 0.0);
    const Eigen::Vector3d n = e3.normalized();
    const bool x_too_near = std::fabs(n.x()) > cos_10_deg;
    const Eigen::Vector3d world = x_too_near ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
    const Eigen::Vector3d e1 = (world - world.dot(n) * n).normalized();
    Frame frame{origin_m, Eigen::Matrix3d::Zero(), kappa_per_m};
    frame.axes.row(0) = e1;
    frame.axes.row(1) = n.cross(e1);
    frame.axes.row(2) = n;
    return frame;
}

std::optional<Eigen::Vector3d> gnomonic(const Frame& frame, const Eigen::Vector3d& local_m) {
    const double kappa = frame.kappa_per_m;
    const double q = 1.0 + kappa * local_m.z();
    if (!(q >= q_min)) return std::nullopt;
    const double side = local_m.x() * local_m.x() + local_m.y() * local_m.y();
    const double rho = std::sqrt(q * q + kappa * kappa * side);
    const double height = (2.0 * local_m.z() + kappa * local_m.squaredNorm()) / (1.0 + rho);
    return Eigen::Vector3d(local_m.x() / q, local_m.y() / q, height);
}

Eigen::Vector3d from_gnomonic(const Frame& frame, double u_m, double v_m, double height_m) {
    const double kappa = frame.kappa_per_m;
    const double side = u_m * u_m + v_m * v_m;
    const double m = std::sqrt(1.0 + kappa * kappa * side);
    const double stretch = (1.0 + kappa * height_m) / m;
    return {stretch * u_m, stretch * v_m, (height_m - kappa * side / (1.0 + m)) / m};
}

Eigen::Vector2d to_plate(const Frame& frame, Projection projection, double u_m, double v_m) {
    const double kappa = frame.kappa_per_m;
    const double m = std::sqrt(1.0 + kappa * kappa * (u_m * u_m + v_m * v_m));
    if (projection == Projection::gall_peters) {
        return {u_m * atan_ratio(kappa * u_m) / sqrt2, sqrt2 * v_m / m};
    }
    const double cosine = 1.0 / m;
    const double shrink = cosine * std::sqrt(2.0 / (1.0 + cosine));
    return {u_m * shrink, v_m * shrink};
}

std::optional<Eigen::Vector2d> from_plate(const Frame& frame, Projection projection,
                                          const Eigen::Vector2d& plate_m) {
    const double kappa = frame.kappa_per_m;
    if (projection == Projection::gall_peters) {
        const double longitude = sqrt2 * kappa * plate_m.x();
        const double z = plate_m.y() / sqrt2;
        const double cos2_latitude = 1.0 - kappa * kappa * z * z;
        if (!(std::fabs(longitude) < half_pi) || !(cos2_latitude > 0.0)) return std::nullopt;
        const double u = sqrt2 * plate_m.x() * tan_ratio(longitude);
        return Eigen::Vector2d(u, z * std::sqrt((1.0 + kappa * kappa * u * u) / cos2_latitude));
    }
    const double sin2_half = 0.25 * kappa * kappa * plate_m.squaredNorm();
    const double cosine = 1.0 - 2.0 * sin2_half;
    if (!(cosine > 0.0)) return std::nullopt;
    const double stretch = std::sqrt(1.0 - sin2_half) / cosine;
    return Eigen::Vector2d(plate_m * stretch);
}

}  // namespace palpate::chart
