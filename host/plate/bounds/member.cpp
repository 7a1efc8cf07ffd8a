#include "host/plate/bounds/member.hpp"

#include <algorithm>
#include <cmath>

#include "host/plate/bounds/modes.hpp"
#include "host/plate/bounds/uniform.hpp"

namespace palpate::plate::bounds {
namespace {

/// Larger of the two densities, strain's and stress's, which differ by rounding; and up.
std::vector<double> upper_density(const Padded& grid, const Vector& of_strain, const Vector& of_stress) {
    Vector most(of_strain.size());
    for (std::size_t i = 0; i < most.size(); ++i) most[i] = std::max(of_strain[i], of_stress[i]);
    std::vector<double> nodes = nodes_of(grid, most);
    for (double& e : nodes) e *= UP;
    return nodes;
}

/// The sums at D = 1, k_f = k0.
void bracket_own(Member& member) {
    Real bending = 0, foundation = 0;
    for (const double e : member.bending) bending += Real(e);
    for (const double g : member.foundation) foundation += Real(g);
    member.bending_sum = static_cast<double>(bending);
    member.foundation_sum = static_cast<double>(foundation);
    const Real energy = bending + Real(member.k0) * foundation;
    const Real norm = std::sqrt(energy) + Real(member.imbalance);
    member.compliance_low = static_cast<double>(Real(member.work) * Real(member.work) / energy) / UP;
    member.compliance_high = static_cast<double>(norm * norm) * UP;
}

/// Half of what inverse iteration says: it comes from above, and to better than a few per cent.
double least_eigenvalue(const Uniform& uniform) {
    constexpr int N_ITERATIONS = 12;
    Vector v = uniform.setting->force;
    Real growth = 0;
    for (int k = 0; k < N_ITERATIONS; ++k) {
        const Real norm = std::sqrt(inner(v, v));
        for (Real& x : v) x /= norm;
        const Vector next = uniform.solve(v);
        growth = std::sqrt(inner(next, next));
        v = next;
    }
    return 0.5 / static_cast<double>(growth);
}

Problem unit_problem(const Problem& problem) {
    const double side_m = problem.size_m.x();
    Problem unit = problem;
    unit.size_m /= side_m;
    unit.lines_x_m /= side_m;
    unit.lines_z_m /= side_m;
    unit.rigidity_n_m.setOnes();
    unit.foundation_n_per_m3.resize(0, 0);
    return unit;
}

}  // namespace

Setting::Setting(const Problem& problem, std::span<const double> nodal_force)
    : unit(unit_problem(problem)), strains(problem), force(strains.grid().size(), Real(0)), load_at{} {
    const Padded& grid = strains.grid();
    double total = 0.0;
    for (std::size_t iz = 0; iz < grid.nz; ++iz) {
        for (std::size_t ix = 0; ix < grid.nx; ++ix) {
            if (!strains.moves(ix, iz)) continue;
            const double f = nodal_force[ix + grid.nx * iz];
            force[grid.at(ix, iz)] = Real(f);
            const auto x = static_cast<Eigen::Index>(ix), z = static_cast<Eigen::Index>(iz);
            const double at_x = unit.lines_x_m.size() != 0 ? unit.lines_x_m(x)
                                                           : unit.size_m.x() * static_cast<double>(ix) /
                                                                 static_cast<double>(grid.nx - 1);
            const double at_z = unit.lines_z_m.size() != 0 ? unit.lines_z_m(z)
                                                           : unit.size_m.y() * static_cast<double>(iz) /
                                                                 static_cast<double>(grid.nz - 1);
            load_at[0] += f * at_x;
            load_at[1] += f * at_z;
            total += f;
        }
    }
    for (double& at : load_at) at /= total;
    const Plate bare(unit);
    least_eigenvalue = bounds::least_eigenvalue({this, &bare, 0});
}

Member make_member(const Setting& setting, double k0, bool with_foundation, Keep keep) {
    Problem problem = setting.unit;
    if (k0 > 0.0) {
        problem.foundation_n_per_m3 =
            Eigen::ArrayXXd::Constant(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols(), k0);
    }
    auto plate = std::make_unique<Plate>(problem);
    const Uniform uniform{&setting, plate.get(), Real(k0)};
    const Padded& grid = setting.strains.grid();
    const Vector w0 = uniform.solve(setting.force);
    Vector strain0 = uniform.strain(w0);
    Vector stress0 = strain0;
    uniform.weigh(stress0);
    uniform.balance(stress0, setting.force);

    Member member;
    member.k0 = k0;
    Real magnitude = 0;
    for (std::size_t i = 0; i < w0.size(); ++i) magnitude += std::fabs(setting.force[i] * w0[i]);
    member.work = static_cast<double>(inner(setting.force, w0) - 0x1p-50L * magnitude);
    const Vector slips = uniform.slips(w0);
    for (std::size_t i = 0; i < strain0.size(); ++i) strain0[i] = std::fabs(strain0[i]) + slips[i];
    member.bending = upper_density(grid, bending_at_nodes(grid, strain0, strain0),
                                   bending_at_nodes(grid, stress0, stress0));
    if (with_foundation) {
        Vector reaction = foundation_at_nodes(grid, stress0, stress0);
        for (Real& g : reaction) g = k0 > 0.0 ? g / (Real(k0) * Real(k0)) : 0;
        member.foundation = upper_density(grid, foundation_at_nodes(grid, strain0, strain0), reaction);
    }
    member.imbalance = uniform.imbalance(stress0, setting.force);
    bracket_own(member);
    if (keep == Keep::sums) return member;

    member.modes = make_modes(uniform, w0, stress0, with_foundation);
    member.plate = std::move(plate);
    member.deflection.assign(w0.begin(), w0.end());
    member.stress.assign(stress0.begin(), stress0.end());
    return member;
}

}  // namespace palpate::plate::bounds
