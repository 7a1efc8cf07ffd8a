#include "host/app/solve_answer.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <future>
#include <thread>
#include <vector>

#include "host/app/interrupt.hpp"
#include "host/plate/grid_family.hpp"
#include "host/plate/shell.hpp"
#include "host/scene/scene.hpp"

namespace palpate::app {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

Vector2d vec(const scene::Vec2& at) {
    return {at[0], at[1]};
}

constexpr Index SHELL_NODES = 65;  ///< one way, odd; the shell's term is smooth

/// Even places, corner to corner, j fastest.
std::vector<Vector2d> even_places(const scene::PlateFile& file, Index nx, Index nz) {
    const Vector2d size_m = vec(file.plate.size_m);
    std::vector<Vector2d> places;
    places.reserve(static_cast<std::size_t>(nx * nz));
    for (Index i = 0; i < nx; ++i) {
        for (Index j = 0; j < nz; ++j) {
            const Vector2d share(static_cast<double>(i) / static_cast<double>(nx - 1),
                                 static_cast<double>(j) / static_cast<double>(nz - 1));
            places.emplace_back(share.cwiseProduct(size_m));
        }
    }
    return places;
}

bool is_curved(const scene::PlateFile& file) {
    return file.plate.curvature_per_m[0] != 0.0 || file.plate.curvature_per_m[1] != 0.0;
}

plate::ShellTerm shell_of(const scene::PlateFile& file) {
    const double h_m = file.plate.thickness_m, nu = file.plate.poisson;
    const plate::Field rigidity =
        plate::sampled(file.rigidity.values_n_m, vec(file.plate.size_m), file.rigidity.sampling);
    Eigen::ArrayXXd young_pa(SHELL_NODES, SHELL_NODES);
    const std::vector<Vector2d> places = even_places(file, SHELL_NODES, SHELL_NODES);
    for (Index i = 0; i < SHELL_NODES; ++i) {
        for (Index j = 0; j < SHELL_NODES; ++j) {
            const Vector2d& at = places[static_cast<std::size_t>(i * SHELL_NODES + j)];
            young_pa(i, j) = 12.0 * (1.0 - nu * nu) * rigidity(at.x(), at.y()) / (h_m * h_m * h_m);
        }
    }
    const auto [kappa1_per_m, kappa2_per_m] = file.plate.curvature_per_m;
    return plate::shell_term({.kappa1_per_m = kappa1_per_m, .kappa2_per_m = kappa2_per_m}, young_pa,
                             Eigen::ArrayXXd::Constant(1, 1, h_m), nu, vec(file.plate.size_m));
}

plate::Sheet sheet_and_warning(const scene::PlateFile& file, std::string& warning) {
    plate::Sheet sheet;
    sheet.size_m = vec(file.plate.size_m);
    sheet.rigidity_n_m = plate::sampled(file.rigidity.values_n_m, sheet.size_m, file.rigidity.sampling);
    sheet.n_values = {file.rigidity.values_n_m.rows(), file.rigidity.values_n_m.cols()};
    sheet.poisson = file.plate.poisson;
    sheet.edges = file.plate.edges;
    const double foundation_n_per_m3 = file.plate.foundation_n_per_m3;
    if (foundation_n_per_m3 > 0.0)
        sheet.foundation_n_per_m3 = [foundation_n_per_m3](double, double) { return foundation_n_per_m3; };
    if (is_curved(file)) {
        const plate::ShellTerm term = shell_of(file);
        sheet.foundation_n_per_m3 =
            plate::sampled(term.foundation_n_per_m3 + foundation_n_per_m3, sheet.size_m);
        if (term.boundary_dominated)
            warning =
                "with this curvature it is the plate's edges that hold the shell; the foundation that "
                "stands for its stretching is a rough guess";
    }
    return sheet;
}

/// For a file that is finer than the grid.
std::string unseen_words(const scene::PlateFile& file) {
    const auto [nx, nz] = file.plate.nodes;
    const Index rows = file.rigidity.values_n_m.rows(), columns = file.rigidity.values_n_m.cols();
    const auto enough = [](Index n, Index values) {
        return std::to_string(std::max(n, 4 * ((std::max<Index>(values, 9) + 2) / 4) + 1));
    };
    return "rigidity.file holds " + std::to_string(rows) + " x " + std::to_string(columns) + " values, " +
           "of which " + std::to_string(nx) + " x " + std::to_string(nz) + " nodes do not see all; " +
           "plate.nodes=[" + enough(nx, rows) + ", " + enough(nz, columns) + "] do";
}

/// What `auto` does without a grid.
bool has_closed_form(const scene::PlateFile& file) {
    const auto& edges = file.plate.edges;
    return file.rigidity.values_n_m.size() == 1 &&
           std::find(edges.begin(), edges.end(), plate::Edge::free) == edges.end();
}

SolveAnswer solve(const scene::PlateFile& file) {
    SolveAnswer answer;
    const auto begin = std::chrono::steady_clock::now();
    const plate::Sheet sheet = sheet_and_warning(file, answer.warning);
    const std::array loads{plate::Load{.at_m = vec(file.load.at_m),
                                       .force_n = file.load.force_n,
                                       .radius_m = file.load.radius_m,
                                       .shape = plate::Load::Shape::pressure}};
    const plate::Accuracy accuracy{.tolerance = file.solver.tolerance,
                                   .method = file.solver.method,
                                   .extrapolate = file.solver.extrapolate,
                                   .options = {.kernel = plate::Kernel::best}};
    plate::Wanted wanted;
    for (const scene::Vec2& at_m : file.output.points_m) wanted.points_m.push_back(vec(at_m));
    const std::size_t n_points = wanted.points_m.size();
    const auto [nx, nz] = file.plate.nodes;
    // As points, not as the solver's field: that lies on lines which move with the load. It is asked for all
    // the same where it keeps `auto` from stopping at a coarser grid.
    const bool field = !file.output.field.empty() || !file.output.plot.empty();
    wanted.field = field && !has_closed_form(file);
    if (field) {
        const std::vector<Vector2d> places = even_places(file, nx, nz);
        wanted.points_m.insert(wanted.points_m.end(), places.begin(), places.end());
    }
    answer.compliance = plate::compliance(sheet, {nx, nz}, loads, accuracy, wanted);
    if (answer.warning.empty() && answer.compliance.nodes.nx > 0 && !plate::sees_all(sheet, {nx, nz}))
        answer.warning = unseen_words(file);
    std::vector<double>& w = answer.compliance.deflection_m;
    answer.compliance.field_m.resize(0, 0);
    if (field && w.size() == wanted.points_m.size()) {
        answer.deflection_m.resize(nx, nz);
        for (Index i = 0; i < nx; ++i) {
            for (Index j = 0; j < nz; ++j)
                answer.deflection_m(i, j) = w[n_points + static_cast<std::size_t>(i * nz + j)];
        }
        w.resize(n_points);
    }
    answer.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return answer;
}

}  // namespace

plate::Sheet sheet_of(const scene::PlateFile& file) {
    std::string warning;
    return sheet_and_warning(file, warning);
}

SolveAnswer solve_answer(const scene::PlateFile& file) {
    constexpr auto LOOK_AGAIN = std::chrono::milliseconds(20);
    std::promise<SolveAnswer> promise;
    std::future<SolveAnswer> answer = promise.get_future();
    // A solver cannot be stopped; a thread can be left behind.
    std::thread([file, to = std::move(promise)]() mutable {
        try {
            to.set_value(solve(file));
        } catch (...) {
            to.set_exception(std::current_exception());
        }
    }).detach();
    while (answer.wait_for(LOOK_AGAIN) != std::future_status::ready) stop_when_interrupted();
    try {
        return answer.get();
    } catch (const std::invalid_argument& error) {
        scene::refuse(file.path.string(), error.what());
    }
}

}  // namespace palpate::app
