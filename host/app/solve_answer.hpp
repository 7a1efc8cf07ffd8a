/// From a plate file to an answer.
#pragma once
#include <Eigen/Core>
#include <string>

#include "host/plate/compliance.hpp"
#include "host/scene/plate_file.hpp"

namespace palpate::app {

struct SolveAnswer {
    plate::Compliance compliance;  ///< its field is not filled
    /// Deflection at plate.nodes even places, corner to corner, (i, j) as in rigidity files; empty unless
    /// output.field or output.plot asks for it and the status is solved.
    Eigen::ArrayXXd deflection_m;
    double wall_s = 0.0;
    std::string warning;  ///< for a person; empty: none
};

/// The plate of the file, independent of any grid. A curvature becomes a foundation.
[[nodiscard]] plate::Sheet sheet_of(const scene::PlateFile& file);

/// Throws scene::Error with the file's name where the plate cannot be solved as asked, plate::Guard where no
/// number can be vouched for, Interrupted (nothing is kept; the work is left as it stands, so that the
/// process must end soon) once an interrupt was noticed.
[[nodiscard]] SolveAnswer solve_answer(const scene::PlateFile& file);

}  // namespace palpate::app
