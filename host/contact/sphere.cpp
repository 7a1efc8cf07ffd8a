#include "host/contact/sphere.hpp"

#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate::contact {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

constexpr Eigen::Index block_rows = 64;
using Block = Eigen::Matrix<double, block_rows + 5, 5>;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Householder reduction of the first `n_rows` rows to a triangle in the top five; the rest is left as
/// rubbish.
void reduce(Block& block, Eigen::Index n_rows) {
    for (Eigen::Index k = 0; k < 5; ++k) {
        double below = 0.0;
        for (Eigen::Index i = k + 1; i < n_rows; ++i) below += block(i, k) * block(i, k);
        const double head = block(k, k);
        if (below == 0.0) continue;
        const double norm = std::sqrt(head * head + below);
        const double pivot = head > 0.0 ? -norm : norm;
        const double v0 = head - pivot;
        const double beta = 2.0 / (v0 * v0 + below);
        for (Eigen::Index j = k + 1; j < 5; ++j) {
            double dot = v0 * block(k, j);
            for (Eigen::Index i = k + 1; i < n_rows; ++i) dot += block(i, k) * block(i, j);
            const double f = beta * dot;
            block(k, j) -= f * v0;
            for (Eigen::Index i = k + 1; i < n_rows; ++i) block(i, j) -= f * block(i, k);
        }
        block(k, k) = pivot;
    }
}

struct Frame {
    Eigen::Vector3d origin_m;
    double scale_m;  ///< weighted rms distance from the origin
};

Frame centre_and_scale(std::span<const Eigen::Vector3d> points_m, std::span<const double> weights) {
    double sum = 0.0;
    int n_weighted = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        if (!(weights[i] > 0.0)) continue;
        // Relative to the first point, so that a far origin costs no digits.
        mean += weights[i] * (points_m[i] - points_m[0]);
        sum += weights[i];
        ++n_weighted;
    }
    if (n_weighted < 4) throw NoFit("fit_sphere: needs at least 4 points of positive weight");
    const Eigen::Vector3d origin = points_m[0] + mean / sum;
    double square = 0.0;
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        if (weights[i] > 0.0) square += weights[i] * (points_m[i] - origin).squaredNorm();
    }
    const double scale = std::sqrt(square / sum);
    if (!(scale > 0.0)) throw NoFit("fit_sphere: all points are in one place");
    return {origin, scale};
}

/// Triangle of sqrt(w) [|x|^2 x y z 1], built in blocks of fixed size: nothing is allocated.
Matrix5 triangle(std::span<const Eigen::Vector3d> points_m, std::span<const double> weights,
                 const Frame& frame) {
    Block block = Block::Zero();
    Eigen::Index row = 5;
    const auto fold = [&] {
        reduce(block, row);
        for (Eigen::Index j = 0; j < 5; ++j) {
            for (Eigen::Index i = j + 1; i < 5; ++i) block(i, j) = 0.0;
        }
        row = 5;
    };
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        if (!(weights[i] > 0.0)) continue;
        const Eigen::Vector3d x = (points_m[i] - frame.origin_m) / frame.scale_m;
        const double root = std::sqrt(weights[i]);
        block(row, 0) = root * x.squaredNorm();
        block(row, 1) = root * x.x();
        block(row, 2) = root * x.y();
        block(row, 3) = root * x.z();
        block(row, 4) = root;
        if (++row == block_rows + 5) fold();
    }
    fold();
    return block.topRows<5>();
}

/// tan of the Jacobi angle that makes (a, c; c, b) diagonal.
double jacobi_tangent(double a, double b, double c) {
    const double z = (b - a) / (2.0 * c);
    const double root = std::sqrt(1.0 + z * z);
    return z >= 0.0 ? 1.0 / (z + root) : -1.0 / (-z + root);
}

constexpr int sweeps_max = 16;  // quadratic: five or six are the rule for five columns

/// One-sided Jacobi: makes the columns of `a` orthogonal and gives the rotation; the singular values are
/// their lengths.
Matrix5 orthogonalise_columns(Matrix5& a) {
    Matrix5 v = Matrix5::Identity();
    for (int sweep = 0; sweep < sweeps_max; ++sweep) {
        bool rotated = false;
        for (Eigen::Index p = 0; p < 4; ++p) {
            for (Eigen::Index q = p + 1; q < 5; ++q) {
                const double aa = a.col(p).squaredNorm();
                const double bb = a.col(q).squaredNorm();
                const double ab = a.col(p).dot(a.col(q));
                if (!(std::fabs(ab) > 2.0 * epsilon * std::sqrt(aa * bb))) continue;
                rotated = true;
                const double t = jacobi_tangent(aa, bb, ab);
                const double c = 1.0 / std::sqrt(1.0 + t * t);
                const double s = c * t;
                for (Matrix5* m : {&a, &v}) {
                    const Vector5 old = m->col(p);
                    m->col(p) = c * old - s * m->col(q);
                    m->col(q) = s * old + c * m->col(q);
                }
            }
        }
        if (!rotated) break;
    }
    return v;
}

/// Two-sided Jacobi: eigenvectors of a symmetric matrix as columns, in no order.
Matrix5 eigenvectors(Matrix5 s) {
    Matrix5 v = Matrix5::Identity();
    for (int sweep = 0; sweep < sweeps_max; ++sweep) {
        bool rotated = false;
        for (Eigen::Index p = 0; p < 4; ++p) {
            for (Eigen::Index q = p + 1; q < 5; ++q) {
                // Relative to the two diagonal entries: the matrix is graded when the data lie on a sphere.
                if (!(std::fabs(s(p, q)) > epsilon * std::sqrt(std::fabs(s(p, p) * s(q, q))))) continue;
                rotated = true;
                const double t = jacobi_tangent(s(p, p), s(q, q), s(p, q));
                const double c = 1.0 / std::sqrt(1.0 + t * t);
                const double sn = c * t;
                const double off = s(p, q);
                s(p, p) -= t * off;
                s(q, q) += t * off;
                s(p, q) = s(q, p) = 0.0;
                for (Eigen::Index k = 0; k < 5; ++k) {
                    if (k != p && k != q) {
                        const double kp = s(k, p);
                        s(k, p) = s(p, k) = c * kp - sn * s(k, q);
                        s(k, q) = s(q, k) = sn * kp + c * s(k, q);
                    }
                    const double vp = v(k, p);
                    v(k, p) = c * vp - sn * v(k, q);
                    v(k, q) = sn * vp + c * v(k, q);
                }
            }
        }
        if (!rotated) break;
    }
    return v;
}

/// u' C u of eq. 1: |b|^2 - 4 u0 u4.
double constraint(const Vector5& u) {
    return u.segment<3>(1).squaredNorm() - 4.0 * u(0) * u(4);
}

/// C^-1 u.
Vector5 inverse_constraint(const Vector5& u) {
    Vector5 y = u;
    y(0) = -0.5 * u(4);
    y(4) = -0.5 * u(0);
    return y;
}

/// The u of least |R u|^2 / (u' C u) over u' C u > 0, scaled to u' C u = 1.
///
/// With R = U S V' and u = V S^-1 z the problem is the smallest positive eigenvalue of S V' C^-1 V S
/// (Chernov's form of Pratt's fit). Here z is turned into u by the ratios s_min / s_i, so data that lie
/// exactly on a sphere (s_min = 0) are the same case as all others, and the candidates are judged by their
/// own quotient, not by the sign of an eigenvalue that may be rounding.
Vector5 least_quotient(const Matrix5& r) {
    Matrix5 us = r;
    const Matrix5 v = orthogonalise_columns(us);
    Vector5 s;
    for (Eigen::Index i = 0; i < 5; ++i) s(i) = us.col(i).norm();
    const double floor = epsilon * s.maxCoeff();
    for (Eigen::Index i = 0; i < 5; ++i) s(i) = std::fmax(s(i), floor);
    const double least = s.minCoeff();

    Matrix5 graded;
    for (Eigen::Index j = 0; j < 5; ++j) {
        const Vector5 cv = inverse_constraint(v.col(j));
        for (Eigen::Index i = 0; i <= j; ++i) graded(i, j) = graded(j, i) = s(i) * v.col(i).dot(cv) * s(j);
    }
    const Matrix5 z = eigenvectors(graded);

    Vector5 best = Vector5::Zero();
    double best_quotient = std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 0; k < 5; ++k) {
        Vector5 y;
        for (Eigen::Index i = 0; i < 5; ++i) y(i) = z(i, k) * (least / s(i));
        const Vector5 u = (v * y).normalized();
        const double square = constraint(u);
        if (!(square > 0.0)) continue;
        const double quotient = (r * u).squaredNorm() / square;
        if (quotient < best_quotient) {
            best_quotient = quotient;
            best = u / std::sqrt(square);
        }
    }
    // u' C u has four positive directions, so at least one candidate passed.
    assert(best_quotient < std::numeric_limits<double>::infinity());
    return best;
}

}  // namespace

Sphere fit_sphere(std::span<const Eigen::Vector3d> points_m, std::span<const double> weights,
                  const Eigen::Vector3d& outward) {
    if (points_m.size() != weights.size()) {
        throw std::invalid_argument("fit_sphere: one weight for each point");
    }
    const Frame frame = centre_and_scale(points_m, weights);
    Vector5 u = least_quotient(triangle(points_m, weights, frame));
    // Back from scaled coordinates; the constraint keeps its value when u is multiplied by the scale.
    u(0) /= frame.scale_m;
    u(4) *= frame.scale_m;
    const double along = u.segment<3>(1).dot(outward);
    // Points all round a sphere have no side: then the object is inside it.
    const bool closed = std::fabs(along) <= 1e-9 * outward.norm();
    if (closed ? u(0) < 0.0 : along < 0.0) u = -u;
    return {frame.origin_m, u};
}

double Sphere::kappa_per_m() const {
    return 2.0 * u(0);
}

double Sphere::distance_m(const Eigen::Vector3d& at_m) const {
    const Eigen::Vector3d x = at_m - origin_m;
    const double value = u(0) * x.squaredNorm() + u.segment<3>(1).dot(x) + u(4);
    // 1 + 4 u0 F is the squared gradient, so this is F over the mean of the gradients here and on the sphere.
    return 2.0 * value / (1.0 + std::sqrt(std::fmax(0.0, 1.0 + 4.0 * u(0) * value)));
}

Eigen::Vector3d Sphere::normal(const Eigen::Vector3d& at_m) const {
    const Eigen::Vector3d gradient = 2.0 * u(0) * (at_m - origin_m) + u.segment<3>(1);
    const double length = gradient.norm();
    return length > 0.0 ? Eigen::Vector3d(gradient / length) : Eigen::Vector3d::UnitZ();
}

Eigen::Vector3d Sphere::project(const Eigen::Vector3d& at_m) const {
    return at_m - distance_m(at_m) * normal(at_m);
}

}  // namespace palpate::contact
