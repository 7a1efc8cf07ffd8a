/// Ways to solve K w = f on one grid, behind one interface.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "host/plate/problem.hpp"

namespace palpate::plate {

enum class Method { automatic, cholesky, multigrid, closed_form, bounds, eigen, jacobi, damped_jacobi, eq7 };
/// `auto cholesky multigrid closed-form bounds eigen jacobi damped-jacobi eq7`
[[nodiscard]] const char* name_of(Method method);
/// nullopt when there is no such method.
[[nodiscard]] std::optional<Method> method_named(std::string_view name);

enum class Status { solved, not_converged, diverged };
/// `solved not-converged diverged`
[[nodiscard]] const char* name_of(Status status);

/// Which compiled kernels run. `portable` gives the same bits on every machine; `best` the fastest that this
/// one has.
enum class Kernel { portable, best };

/// When an iteration may end: on the true residual, or on the change of one sweep (the paper's rule, which
/// says nothing about the error).
enum class StopRule { residual, change };

struct Options {
    double tolerance =
        1e-6;  ///< of the true residual |K w - f|/|f|, or of |w' - w|/|w'| with StopRule::change
    StopRule stop = StopRule::residual;
    long sweeps_max = 100000;  ///< of Jacobi's sweeps and of multigrid's iterations
    Kernel kernel = Kernel::portable;
};

/// A direct method that leaves more throws Guard.
constexpr double RESIDUAL_MAX = 1e-7;

/// How a solution came about. `w` is to be used if the status is `solved` only; otherwise it is the last
/// iterate.
struct Report {
    Status status = Status::solved;
    long iterations = 0;    ///< 0: direct
    double residual = 0.0;  ///< |K w - f|_max/|f|_max, true
};

/// A plate made ready by one method: factorise once, ask often. Const calls may run in parallel.
class Solver {
public:
    virtual ~Solver() = default;
    /// Another D on the same grid; all else stays, but for jumps on grid lines, of which there are none any
    /// more. Does not allocate, except eigen and eq7. Throws std::invalid_argument on a wrong size, Guard
    /// when D is not positive and finite, the old D then stays, or when a factor of it cannot be trusted:
    /// every solve then throws the same until a good D is set.
    virtual void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) = 0;
    /// Deflection at the nodes in m under forces at the nodes in N, both nodes of the grid (ix, iz), ix
    /// fastest. Forces on nodes that cannot move do nothing. Multigrid and Jacobi do not allocate. Throws
    /// std::invalid_argument on a wrong size, Guard when a force is not finite, when the work of the forces
    /// is not positive, or when a direct method leaves a residual above 1e-7.
    [[nodiscard]] virtual Report solve(std::span<const double> force_n,
                                       std::span<double> deflection_m) const = 0;
    /// Which kernels run: `baseline`, `x86-64-v3`, `x86-64-v4`, `eigen`.
    [[nodiscard]] virtual std::string kernel() const = 0;
};

/// Cholesky, multigrid, eigen, jacobi, damped_jacobi and eq7. Throws std::invalid_argument with
/// problem_with(problem) or when the method cannot solve such a problem, Guard when no number can be vouched
/// for.
[[nodiscard]] std::unique_ptr<Solver> make_solver(Method method, const Problem& problem,
                                                  const Options& options = {});

}  // namespace palpate::plate
