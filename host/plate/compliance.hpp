/// One question, one answer: how far a plate gives way, by whatever method is good enough, and how sure that
/// is.
#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/plate/field.hpp"
#include "host/plate/solver.hpp"

namespace palpate::plate {

/// A push on the plate. All loads of a question act together.
struct Load {
    enum class Shape {
        pressure,  ///< even over a disc; of radius 0, a point
        punch      ///< a flat rigid disc: all that it touches moves alike
    };
    Eigen::Vector2d at_m{0.0, 0.0};
    double force_n = 1.0;
    double radius_m = 0.0;
    Shape shape = Shape::pressure;
};

struct Accuracy {
    double tolerance = 1e-3;  ///< relative, of the continuum's compliance at the first load
    Method method = Method::automatic;
    bool extrapolate = true;  ///< from the asked grid and coarser ones to the continuum
    bool bracket = true;      ///< certify: 10 to 500 ms more
    Options
        options{};  ///< of the iterative methods; `tolerance` is derived unless the stop rule is the paper's
};

/// A grid to solve on: the finest one; each count 4 m + 1 when extrapolating.
struct Nodes {
    Eigen::Index nx = 33, nz = 33;
};

struct Compliance {
    Status status = Status::solved;
    double m_per_n = std::numeric_limits<double>::quiet_NaN();        ///< only when solved
    double relative_error = std::numeric_limits<double>::infinity();  ///< estimated, about the continuum
    std::optional<std::array<double, 2>> bracket_m_per_n;  ///< certified; none where no certificate exists
    std::string no_bracket_why;
    Method method = Method::cholesky;
    std::string why, kernel;
    Nodes nodes;  ///< of the finest grid that was solved on; 0 x 0: none
    double residual = 0.0;
    long iterations = 0;
    std::vector<double> deflection_m;  ///< at each asked point, under all loads
    Eigen::ArrayXXd field_m;           ///< at the nodes of `nodes`, under all loads; empty unless asked for
};

/// What else to tell besides the compliance.
struct Wanted {
    std::vector<Eigen::Vector2d> points_m;
    bool field = false;
};

/// Deflection at the first load per newton of it (mean over its disc), when it acts alone. Throws
/// std::invalid_argument in words for a person, Guard when no method can vouch for a number; a method that
/// diverges or does not converge is an answer, see `status`.
[[nodiscard]] Compliance compliance(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads,
                                    const Accuracy& accuracy = {}, const Wanted& wanted = {});

}  // namespace palpate::plate
