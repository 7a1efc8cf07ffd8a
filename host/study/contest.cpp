#include "host/study/contest.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "host/plate/bounds/bounds.hpp"
#include "host/plate/plate.hpp"
#include "host/plate/uniform/closed_form.hpp"
#include "host/plate/uniform/uniform.hpp"
#include "host/study/stopwatch.hpp"

namespace palpate::study {
namespace {

using Eigen::Index;
using plate::Method;
using plate::Problem;
using Call = std::function<Outcome()>;

std::size_t size(Index n) {
    return static_cast<std::size_t>(n);
}

Problem problem_of(const Setup& setup, Index nodes) {
    return plate::on_grid(setup.sheet, nodes, nodes);
}

Outcome outcome_from(const plate::Report& report, double m_per_n, std::string kernel) {
    return {.status = plate::name_of(report.status),
            .words = {},
            .m_per_n = m_per_n,
            .stated_error = std::nullopt,
            .iterations = report.iterations,
            .residual = report.residual,
            .kernel = std::move(kernel)};
}

/// The direct method as it is meant to be used: D in, compliance of the centre out, no solve.
Call cholesky(const Setup& setup) {
    const Problem problem = problem_of(setup, setup.nodes);
    const auto answer = [](const plate::Plate& plate) {
        return outcome_from({}, plate.centre_compliance_m_per_n(), plate.kernel());
    };
    if (setup.on_lines) {
        return [problem, answer, kernel = setup.kernel] { return answer(plate::Plate(problem, kernel)); };
    }
    const auto plate = std::make_shared<plate::Plate>(problem, setup.kernel);
    return [plate, problem, answer] {
        plate->set_rigidity(problem.rigidity_n_m);
        return answer(*plate);
    };
}

/// Two grids to the continuum (MATH.md eq. 8-9).
Call extrapolated(const Setup& setup) {
    const Index coarse_nodes = (setup.nodes + 1) / 2;
    const Problem fine = problem_of(setup, setup.nodes), coarse = problem_of(setup, coarse_nodes);
    const auto corrected = [](const plate::Plate& plate, const Problem& problem) {
        const Index centre = problem.rigidity_n_m.rows() / 2;
        return plate.centre_compliance_m_per_n() - plate::local_grid_error_m_per_n(problem, {centre, centre});
    };
    const double stated = plate::extrapolated_centre_compliance(fine).relative_error;
    const auto joined = [stated](double on_fine, double on_coarse, const plate::Plate& plate) {
        Outcome outcome = outcome_from({}, (4.0 * on_fine - on_coarse) / 3.0, plate.kernel());
        outcome.stated_error = stated;
        if (!(outcome.m_per_n > 0.0)) throw plate::Guard("extrapolated compliance is not positive");
        return outcome;
    };
    if (setup.on_lines) {
        return [fine, coarse, corrected, joined, kernel = setup.kernel] {
            const plate::Plate on_fine(fine, kernel), on_coarse(coarse, kernel);
            return joined(corrected(on_fine, fine), corrected(on_coarse, coarse), on_fine);
        };
    }
    const auto on_fine = std::make_shared<plate::Plate>(fine, setup.kernel);
    const auto on_coarse = std::make_shared<plate::Plate>(coarse, setup.kernel);
    return [on_fine, on_coarse, fine, coarse, corrected, joined] {
        on_fine->set_rigidity(fine.rigidity_n_m);
        on_coarse->set_rigidity(coarse.rigidity_n_m);
        return joined(corrected(*on_fine, fine), corrected(*on_coarse, coarse), *on_fine);
    };
}

/// Any Solver: D in, one load, its deflection out.
Call solved(Method method, const Setup& setup, const plate::Options& options) {
    const Problem problem = problem_of(setup, setup.nodes);
    const std::vector<double> force = centre_force(setup.nodes, setup.nodes);
    const auto room = std::make_shared<std::vector<double>>(force.size(), 0.0);
    const auto ask = [force, room, centre = force.size() / 2](const plate::Solver& solver) {
        const plate::Report report = solver.solve(force, *room);
        return outcome_from(report, (*room)[centre], solver.kernel());
    };
    if (setup.on_lines) {
        return [problem, method, options, ask] { return ask(*plate::make_solver(method, problem, options)); };
    }
    const std::shared_ptr<plate::Solver> solver = plate::make_solver(method, problem, options);
    return [problem, solver, ask] {
        solver->set_rigidity(problem.rigidity_n_m);
        return ask(*solver);
    };
}

/// |c - c_h| = |r'w| <= |r|_1 max w: the residual that leaves an error of `tolerance`.
double residual_for(double tolerance, Index nodes) {
    return tolerance / static_cast<double>(nodes * nodes);
}

/// As many sweeps as four fifths of the budget hold.
long sweeps_within(const Setup& setup, Method method) {
    constexpr long PROBE = 512;
    const plate::Options probe{
        .tolerance = 1e-300, .stop = plate::StopRule::residual, .sweeps_max = PROBE, .kernel = setup.kernel};
    const Call call = solved(method, setup, probe);
    double least_s = std::numeric_limits<double>::infinity();  // others' work only ever adds
    for (int i = 0; i < 5; ++i) {
        const double begin_s = now_s();
        call();
        least_s = std::min(least_s, now_s() - begin_s);
    }
    return std::max<long>(PROBE, static_cast<long>(0.8 * setup.budget_s * PROBE / least_s));
}

Call damped_jacobi(const Setup& setup, plate::StopRule stop, double tolerance) {
    return solved(Method::damped_jacobi, setup,
                  {.tolerance = tolerance,
                   .stop = stop,
                   .sweeps_max = sweeps_within(setup, Method::damped_jacobi),
                   .kernel = setup.kernel});
}

Call multigrid(const Setup& setup, double tolerance) {
    return solved(Method::multigrid, setup,
                  {.tolerance = tolerance, .sweeps_max = 1000, .kernel = setup.kernel});
}

Call direct(Method method, const Setup& setup) {
    return solved(method, setup, {.sweeps_max = 1000, .kernel = setup.kernel});
}

Call closed_form(const Setup& setup) {
    return [sheet = setup.sheet] {
        const Eigen::Vector2d centre = 0.5 * sheet.size_m;
        const plate::UniformPlate plate{
            .size_m = sheet.size_m,
            .rigidity_n_m = sheet.rigidity_n_m(centre.x(), centre.y()),
            .foundation_n_per_m3 =
                sheet.foundation_n_per_m3 ? sheet.foundation_n_per_m3(centre.x(), centre.y()) : 0.0,
            .edges = sheet.edges};
        const plate::ClosedForm form = plate::UniformSolution(plate, {.at_m = centre}).compliance();
        Outcome outcome = outcome_from({}, form.m_per_n, "plain");
        outcome.stated_error = form.relative_error;
        return outcome;
    };
}

/// By nodes, and whether there is a foundation: the values of D and k_f do not matter to them.
using KeptBounds = std::map<std::pair<Index, bool>, std::shared_ptr<plate::Bounds>>;

/// The bracket's middle; its half width is stated, of the discrete plate.
Call bracket(const Setup& setup, plate::Rung rung, KeptBounds& kept) {
    const Problem problem = problem_of(setup, setup.nodes);
    if (const auto why = plate::Bounds::none_because(problem)) throw std::invalid_argument(*why);
    auto& bounds = kept[{setup.nodes, problem.foundation_n_per_m3.size() != 0}];
    if (!bounds) bounds = std::make_shared<plate::Bounds>(problem, centre_force(setup.nodes, setup.nodes));
    const auto scratch = std::make_shared<plate::Bounds::Scratch>(*bounds);
    return [problem, bounds = bounds, scratch, rung] {
        const auto span_of = [](const Eigen::ArrayXXd& field) {
            return std::span<const double>(field.data(), size(field.size()));
        };
        const plate::Bracket found =
            bounds->bracket(span_of(problem.rigidity_n_m), span_of(problem.foundation_n_per_m3),
                            {.relative_error = 0.0, .last = rung}, *scratch);
        Outcome outcome = outcome_from({}, found.middle_m_per_n(), "plain");
        outcome.stated_error = found.relative_error();
        return outcome;
    };
}

}  // namespace

std::vector<double> centre_force(Index nx, Index nz) {
    std::vector<double> force(size(nx * nz), 0.0);
    force[size(nx / 2 + nx * (nz / 2))] = 1.0;
    return force;
}

Outcome outcome_of(const Call& call) {
    Outcome outcome;
    try {
        outcome = call();
        if (!std::isfinite(outcome.m_per_n)) outcome.m_per_n = std::numeric_limits<double>::quiet_NaN();
    } catch (const std::invalid_argument& error) {
        outcome.status = "refused";
        outcome.words = error.what();
    } catch (const plate::Guard& error) {
        outcome.status = "guard";
        outcome.words = error.what();
    }
    return outcome;
}

std::vector<Contestant> contestants() {
    using plate::Rung;
    using plate::StopRule;
    const auto kept = std::make_shared<KeptBounds>();
    return {
        {.name = "cholesky", .words = "multifrontal Cholesky, one grid", .prepare = cholesky},
        {.name = "cholesky-extrapolated",
         .words = "the same on n and (n + 1)/2 nodes, to the continuum",
         .prepare = extrapolated},
        {.name = "multigrid-1e-3",
         .words = "conjugate gradients with multigrid, to a residual of 1e-3",
         .prepare = [](const Setup& setup) { return multigrid(setup, 1e-3); }},
        {.name = "multigrid-1e-6",
         .words = "the same to 1e-6",
         .prepare = [](const Setup& setup) { return multigrid(setup, 1e-6); }},
        {.name = "eigen",
         .words = "Eigen::SimplicialLDLT",
         .prepare = [](const Setup& setup) { return direct(Method::eigen, setup); }},
        {.name = "eq7",
         .words = "the paper's equation 7, differences, solved exactly",
         .prepare = [](const Setup& setup) { return direct(Method::eq7, setup); }},
        {.name = "jacobi",
         .words = "the paper's iteration",
         .prepare =
             [](const Setup& setup) {
                 return solved(Method::jacobi, setup,
                               {.tolerance = residual_for(1e-3, setup.nodes), .kernel = setup.kernel});
             }},
        {.name = "damped-jacobi",
         .words = "damped 0.62, to 1e-3 on the true residual",
         .prepare =
             [](const Setup& setup) {
                 return damped_jacobi(setup, StopRule::residual, residual_for(1e-3, setup.nodes));
             }},
        {.name = "damped-jacobi-change-1e-3",
         .words = "the same, stopped by the paper's rule at 1e-3",
         .prepare = [](const Setup& setup) { return damped_jacobi(setup, StopRule::change, 1e-3); }},
        {.name = "damped-jacobi-change-1e-6",
         .words = "the same, at 1e-6",
         .prepare = [](const Setup& setup) { return damped_jacobi(setup, StopRule::change, 1e-6); }},
        {.name = "closed-form",
         .words = "series of edge moments",
         .uniform_only = true,
         .prepare = closed_form},
        {.name = "bounds-uniform",
         .words = "certified bracket from one uniform plate; its middle",
         .prepare = [kept](const Setup& setup) { return bracket(setup, Rung::uniform, *kept); }},
        {.name = "bounds-modes",
         .words = "the same with seven sensitivities",
         .prepare = [kept](const Setup& setup) { return bracket(setup, Rung::modes, *kept); }},
        {.name = "bounds-krylov-3",
         .words = "the same with three trials of conjugate gradients",
         .prepare = [kept](const Setup& setup) { return bracket(setup, Rung::krylov3, *kept); }},
    };
}

}  // namespace palpate::study
