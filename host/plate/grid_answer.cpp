#include "host/plate/grid_answer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "host/plate/plate.hpp"
#include "host/plate/uniform/closed_form.hpp"
#include "host/plate/uniform/uniform.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

bool is_punch(const Load& load) {
    return load.shape == Load::Shape::punch;
}

bool is_point(const Load& load) {
    return load.shape == Load::Shape::pressure && load.radius_m == 0.0;
}

std::optional<NodeAt> wanted_node(std::span<const Load> loads, int halvings) {
    if (is_point(loads.front())) return NodeAt{loads.front().at_m, halvings};
    return std::nullopt;
}

double dot(std::span<const double> a, std::span<const double> b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Column of K^-1 under forces, with what it takes to say how it came about.
class Columns {
public:
    Columns(const Solver& solver, std::size_t n) : solver_(solver), n_(n) {}

    std::vector<double> under(std::span<const double> force_n) {
        std::vector<double> w(n_);
        const Report one = solver_.solve(force_n, w);
        report.iterations += one.iterations;
        report.residual = std::max(report.residual, one.residual);
        if (report.status == Status::solved) report.status = one.status;
        return w;
    }

    Report report;

private:
    const Solver& solver_;
    std::size_t n_;
};

/// Forces under flat rigid punches: every node that a punch touches moves alike, and they add up to its
/// force. `others`: punches that do not act.
class Punches {
public:
    Punches(const OnGrid& grid, std::span<const Load> loads, Columns& columns) : n_(grid.pressure_n.size()) {
        for (const Load& load : loads) {
            if (!is_punch(load)) continue;
            for (const Node& node : touched_nodes(grid.lines, load.at_m, load.radius_m)) {
                nodes_.push_back(static_cast<std::size_t>(node.ix + grid.lines.x_m.size() * node.iz));
                punch_of_.push_back(forces_n_.size());
            }
            forces_n_.push_back(load.force_n);
        }
        const auto m = static_cast<Index>(nodes_.size());
        const auto k = static_cast<Index>(forces_n_.size());
        bordered_ = Eigen::MatrixXd::Zero(m + k, m + k);
        for (Index j = 0; j < m; ++j) {
            std::vector<double> unit(n_, 0.0);
            unit[nodes_[size(j)]] = 1.0;
            const std::vector<double> w = columns.under(unit);
            for (Index i = 0; i < m; ++i) bordered_(i, j) = w[nodes_[size(i)]];
        }
        scale_ = m > 0 ? bordered_(0, 0) : 1.0;  // m/N: keeps the border as large as the rest
        for (Index i = 0; i < m; ++i) {
            const Index punch = m + static_cast<Index>(punch_of_[size(i)]);
            bordered_(i, punch) = -scale_;
            bordered_(punch, i) = -scale_;
        }
    }

    [[nodiscard]] bool any() const { return !forces_n_.empty(); }

    /// Forces at all nodes where other loads deflect the plate by `by_others`, all punches pressed.
    [[nodiscard]] std::vector<double> pressed(std::span<const double> by_others) const {
        return solve(by_others, forces_n_);
    }
    /// Depth of the first punch under 1 N on it alone, nothing else touching.
    [[nodiscard]] double first_compliance() const {
        const auto own = std::count(punch_of_.begin(), punch_of_.end(), 0U);
        const Eigen::MatrixXd g = bordered_.topLeftCorner(own, own);
        return 1.0 / g.partialPivLu().solve(Eigen::VectorXd::Ones(own)).sum();
    }

private:
    static std::size_t size(Index i) { return static_cast<std::size_t>(i); }

    [[nodiscard]] std::vector<double> solve(std::span<const double> w,
                                            const std::vector<double>& forces_n) const {
        const auto m = static_cast<Index>(nodes_.size());
        Eigen::VectorXd right(bordered_.rows());
        for (Index i = 0; i < m; ++i) right(i) = w.empty() ? 0.0 : -w[nodes_[size(i)]];
        for (Index k = 0; m + k < right.size(); ++k) right(m + k) = -scale_ * forces_n[size(k)];
        const Eigen::VectorXd solved = bordered_.partialPivLu().solve(right);
        std::vector<double> force_n(n_, 0.0);
        for (Index i = 0; i < m; ++i) force_n[nodes_[size(i)]] += solved(i);
        return force_n;
    }

    std::size_t n_;
    std::vector<std::size_t> nodes_, punch_of_;
    std::vector<double> forces_n_;
    Eigen::MatrixXd bordered_;
    double scale_ = 1.0;
};

/// Uniform plate with the grid, the edges and the loads of another.
Problem uniform_on(const Problem& problem, double rigidity_n_m, double foundation_n_per_m3) {
    const Index nx = problem.rigidity_n_m.rows(), nz = problem.rigidity_n_m.cols();
    Problem uniform;
    uniform.size_m = problem.size_m;
    uniform.rigidity_n_m = Eigen::ArrayXXd::Constant(nx, nz, rigidity_n_m);
    if (foundation_n_per_m3 > 0.0)
        uniform.foundation_n_per_m3 = Eigen::ArrayXXd::Constant(nx, nz, foundation_n_per_m3);
    uniform.poisson = problem.poisson;
    uniform.edges = problem.edges;
    uniform.lines_x_m = problem.lines_x_m;
    uniform.lines_z_m = problem.lines_z_m;
    return uniform;
}

bool has_free_edge(const Sheet& sheet) {
    return std::find(sheet.edges.begin(), sheet.edges.end(), Edge::free) != sheet.edges.end();
}

}  // namespace

OnGrid::OnGrid(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads, int halvings)
    : problem(on_grid(sheet, nodes.nx, nodes.nz, wanted_node(loads, halvings))), lines(problem) {
    pressure_n.assign(static_cast<std::size_t>(nodes.nx * nodes.nz), 0.0);
    for (const Load& load : loads) {
        if (is_punch(load)) continue;
        const std::vector<double> unit = unit_pressure(lines, load.at_m, load.radius_m);
        if (&load == loads.data()) unit_force = unit;
        for (std::size_t i = 0; i < unit.size(); ++i) pressure_n[i] += load.force_n * unit[i];
    }
}

GridAnswer answer_on(const OnGrid& grid, std::span<const Load> loads,
                     std::span<const Eigen::Vector2d> points_m, Method method, const Options& options) {
    const std::unique_ptr<Solver> solver = make_solver(method, grid.problem, options);
    Columns columns(*solver, grid.pressure_n.size());
    GridAnswer answer;
    answer.kernel = solver->kernel();
    const bool alone = loads.size() == 1 && !is_punch(loads.front());
    std::vector<double> w;
    if (!grid.unit_force.empty()) {
        w = columns.under(grid.unit_force);
        answer.m_per_n = dot(grid.unit_force, w);
    }
    if (alone) {
        for (double& value : w) value *= loads.front().force_n;
    } else {
        const Punches punches(grid, loads, columns);
        if (is_punch(loads.front())) answer.m_per_n = punches.first_compliance();
        std::vector<double> force_n = grid.pressure_n;
        if (punches.any()) {
            const std::vector<double> under = punches.pressed(columns.under(grid.pressure_n));
            for (std::size_t i = 0; i < force_n.size(); ++i) force_n[i] += under[i];
        }
        w = columns.under(force_n);
    }
    for (const Eigen::Vector2d& point : points_m)
        answer.points_m.push_back(deflection_at(grid.lines, point, w));
    answer.field_m = std::move(w);
    answer.report = columns.report;
    return answer;
}

std::optional<Twin> Twin::of(const Sheet& sheet, const Load& load) {
    Twin twin;
    twin.load_ = load;
    twin.rigidity_n_m_ = sheet.rigidity_n_m(load.at_m.x(), load.at_m.y());
    if (sheet.foundation_n_per_m3)
        twin.foundation_n_per_m3_ = sheet.foundation_n_per_m3(load.at_m.x(), load.at_m.y());
    if (is_punch(load)) return std::nullopt;
    if (has_free_edge(sheet) || sheet.solid) {
        if (is_point(load)) return twin;
        return std::nullopt;
    }
    try {
        const UniformPlate plate{.size_m = sheet.size_m,
                                 .rigidity_n_m = twin.rigidity_n_m_,
                                 .foundation_n_per_m3 = twin.foundation_n_per_m3_,
                                 .edges = sheet.edges};
        const UniformSolution solution(plate, {.at_m = load.at_m, .radius_m = load.radius_m});
        twin.exact_m_per_n_ = solution.compliance().m_per_n;
    } catch (const std::invalid_argument&) {  // out of the series' reach
        if (!is_point(load)) return std::nullopt;
    }
    return twin;
}

double Twin::grid_error_m_per_n(const OnGrid& grid) const {
    if (!exact_m_per_n_) {
        return local_grid_error_m_per_n(grid.problem, nearest_node(grid.problem, load_.at_m));
    }
    const Plate plate(uniform_on(grid.problem, rigidity_n_m_, foundation_n_per_m3_));
    std::vector<double> w(grid.unit_force.size());
    plate.solve(grid.unit_force, w);
    return dot(grid.unit_force, w) - *exact_m_per_n_;
}

}  // namespace palpate::plate
