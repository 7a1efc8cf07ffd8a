/// The methods that compete: from a new D to the centre's compliance, everything else made ready beforehand.
#pragma once
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/plate/solver.hpp"
#include "host/study/plates.hpp"

namespace palpate::study {

/// What a method said.
struct Outcome {
    std::string status = "solved";  ///< solved, not-converged, diverged; refused, guard: no number
    std::string words;              ///< of a refusal or a guard
    double m_per_n = std::numeric_limits<double>::quiet_NaN();
    std::optional<double> stated_error;  ///< relative, where the method states one
    long iterations = 0;
    double residual = std::numeric_limits<double>::quiet_NaN();
    std::string kernel;
};

struct Setup {
    plate::Sheet sheet;
    bool on_lines = false;  ///< D jumps on grid lines: set_rigidity cannot, a new solver each time
    Eigen::Index nodes = 33;
    double budget_s = 0.18;  ///< for one solution by sweeps
    plate::Kernel kernel = plate::Kernel::best;
};

struct Contestant {
    std::string name;
    std::string words;
    bool uniform_only = false;
    /// Makes all ready that does not depend on the values of D. The result may be called often and sets D
    /// each time. Both throw std::invalid_argument (the method cannot) and plate::Guard.
    std::function<std::function<Outcome()>(const Setup&)> prepare;
};

/// cholesky cholesky-extrapolated multigrid-1e-3 multigrid-1e-6 eigen eq7 jacobi damped-jacobi
/// damped-jacobi-change-1e-3 damped-jacobi-change-1e-6 closed-form bounds-uniform bounds-modes
/// bounds-krylov-3. Multigrid stops when the true residual is that much of the load. Jacobi's iteration,
/// whose residual is small long before its error is, stops at 1e-3 over the number of nodes: the compliance
/// is then within 1e-3 of the grid's where the deflection is largest at the load; or by the change of one
/// sweep.
[[nodiscard]] std::vector<Contestant> contestants();

/// prepare and the first call with refusals and guards as outcomes.
[[nodiscard]] Outcome outcome_of(const std::function<Outcome()>& call);

/// 1 N on the centre node, x fastest.
[[nodiscard]] std::vector<double> centre_force(Eigen::Index nx, Eigen::Index nz);

}  // namespace palpate::study
