// The sum of squares that the bounds are made of is the stiffness matrix that the plate is solved with.
#include "host/plate/bounds/strains.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "host/plate/plate.hpp"
#include "tests/host/plate/fields.hpp"

using namespace palpate::plate;
using bounds::Padded;
using bounds::Strains;
using Eigen::ArrayXXd;
using Eigen::Index;

namespace {

/// B' diag(d) B w for the unit vector of a node, lengths over the side along x.
std::vector<double> column(const Strains<double>& strains, const Problem& problem, std::size_t ix,
                           std::size_t iz) {
    const Padded& grid = strains.grid();
    const std::size_t n = grid.size();
    std::vector<double> w(n, 0.0), strain(strains.n_rows()), force(n);
    w[grid.at(ix, iz)] = 1.0;
    strains.strain(w.data(), strain.data());
    const auto d = [&](std::size_t i, std::size_t j) {
        return problem.rigidity_n_m(static_cast<Index>(i), static_cast<Index>(j));
    };
    for (std::size_t j = 0; j < grid.nz; ++j) {
        for (std::size_t i = 0; i < grid.nx; ++i) {
            const std::size_t c = grid.at(i, j);
            strain[bounds::ALONG_X * n + c] *= d(i, j);
            strain[bounds::ALONG_Z * n + c] *= d(i, j);
            if (i + 1 < grid.nx && j + 1 < grid.nz)
                strain[bounds::TWIST * n + c] *=
                    0.25 * (d(i, j) + d(i + 1, j) + d(i, j + 1) + d(i + 1, j + 1));
            const double side2 = problem.size_m.x() * problem.size_m.x();
            strain[bounds::FOUNDATION * n + c] *=
                problem.foundation_n_per_m3(static_cast<Index>(i), static_cast<Index>(j)) * side2 * side2;
        }
    }
    strains.force(strain.data(), force.data());
    return force;
}

}  // namespace

TEST_CASE(
    "strains weighted by D and k_f make the plate's stiffness matrix, whatever its edges and grid lines") {
    const auto edges = GENERATE(as<std::array<Edge, 4>>{}, std::array<Edge, 4>{},
                                std::array{Edge::supported, Edge::clamped, Edge::free, Edge::supported},
                                std::array{Edge::clamped, Edge::free, Edge::clamped, Edge::free});
    const bool even = GENERATE(as<bool>{}, true, false);
    fields::Random random(3);
    Problem problem;
    problem.size_m = {0.04, 0.03};
    problem.poisson = 0.37;
    problem.edges = edges;
    problem.rigidity_n_m = ArrayXXd::NullaryExpr(7, 6, [&] { return 0.1 + random.next(); });
    problem.foundation_n_per_m3 = ArrayXXd::NullaryExpr(7, 6, [&] { return 1e6 * random.next(); });
    if (!even) {
        problem.lines_x_m = Eigen::ArrayXd::LinSpaced(7, 0.0, 1.0).square() * 0.5 * 0.04 +
                            Eigen::ArrayXd::LinSpaced(7, 0.0, 1.0) * 0.5 * 0.04;
        problem.lines_z_m = Eigen::ArrayXd::LinSpaced(6, 0.0, 1.0).sqrt() * 0.2 * 0.03 +
                            Eigen::ArrayXd::LinSpaced(6, 0.0, 1.0) * 0.8 * 0.03;
    }
    const Eigen::MatrixXd stiffness = Plate(problem).dense_stiffness_n_per_m();
    const Strains<double> strains(problem);
    std::vector<std::size_t> places;  // in the order of the matrix: x slowest
    for (std::size_t ix = 0; ix < 7; ++ix) {
        for (std::size_t iz = 0; iz < 6; ++iz) {
            if (strains.moves(ix, iz)) places.push_back(strains.grid().at(ix, iz));
        }
    }
    REQUIRE(static_cast<Index>(places.size()) == stiffness.rows());
    const double to_n_per_m = 1.0 / (0.04 * 0.04);
    Index j = 0;
    for (std::size_t ix = 0; ix < 7; ++ix) {
        for (std::size_t iz = 0; iz < 6; ++iz) {
            if (!strains.moves(ix, iz)) continue;
            const std::vector<double> force = column(strains, problem, ix, iz);
            for (Index i = 0; i < stiffness.rows(); ++i) {
                INFO("entry " << i << ", " << j);
                REQUIRE(force[places[static_cast<std::size_t>(i)]] * to_n_per_m ==
                        Approx(stiffness(i, j)).margin(1e-12 * stiffness.maxCoeff()).epsilon(1e-12));
            }
            ++j;
        }
    }
}
