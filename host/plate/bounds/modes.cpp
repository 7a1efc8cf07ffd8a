#include "host/plate/bounds/modes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace palpate::plate::bounds {
namespace {

constexpr Real MODE_IS_NEW = 1e-9L;  ///< of its energy, after the earlier ones are taken out

/// p_j(x, z) about the load at the rows of B: nodes, and means of the corners for cells.
Vector pattern(const Setting& setting, const std::function<double(double, double)>& p) {
    const Padded& grid = setting.strains.grid();
    const Problem& unit = setting.unit;
    const std::size_t n = grid.size(), s = grid.stride();
    Vector rows(N_KINDS * n, Real(0));
    const auto at = [](const Eigen::ArrayXd& lines, std::size_t i, std::size_t count, double length) {
        return lines.size() != 0 ? lines(static_cast<Eigen::Index>(i))
                                 : length * static_cast<double>(i) / static_cast<double>(count - 1);
    };
    for (std::size_t iz = 0; iz < grid.nz; ++iz) {
        for (std::size_t ix = 0; ix < grid.nx; ++ix) {
            const double x = at(unit.lines_x_m, ix, grid.nx, unit.size_m.x()) - setting.load_at[0];
            const double z = at(unit.lines_z_m, iz, grid.nz, unit.size_m.y()) - setting.load_at[1];
            for (const Kind kind : {ALONG_X, ALONG_Z, FOUNDATION})
                rows[kind * n + grid.at(ix, iz)] = Real(p(x, z));
        }
    }
    for (std::size_t iz = 0; iz + 1 < grid.nz; ++iz) {
        for (std::size_t ix = 0; ix + 1 < grid.nx; ++ix) {
            const std::size_t c = grid.at(ix, iz);
            rows[TWIST * n + c] = (rows[c] + rows[c + 1] + rows[c + s] + rows[c + s + 1]) / 4;
        }
    }
    return rows;
}

/// What D may look like about the load; lengths over the shorter side.
std::vector<std::function<double(double, double)>> patterns(double side) {
    const auto gauss = [side](double sigma) {
        return [v = 2 * sigma * sigma * side * side](double x, double z) {
            return std::exp(-(x * x + z * z) / v);
        };
    };
    return {[](double x, double) { return x; },
            [](double, double z) { return z; },
            [](double x, double) { return x * x; },
            [](double, double z) { return z * z; },
            [](double x, double z) { return x * z; },
            gauss(0.1),
            gauss(0.05)};
}

/// The first answer of the uniform plate to D = 1 + p: dw = -K^-1 K(p) w0, and its stress (MATH.md eq. 52).
struct Pairs {
    std::vector<Vector> deflections, stresses;
};

void add_mode(const Uniform& uniform, const Vector& w0, Vector weights, Pairs& pairs) {
    Vector stress = uniform.strain(w0);
    for (std::size_t i = 0; i < stress.size(); ++i) stress[i] *= weights[i];
    uniform.weigh(stress);
    Vector dw = uniform.solve(uniform.force(stress));
    for (Real& v : dw) v = -v;
    Vector from_dw = uniform.strain(dw);
    uniform.weigh(from_dw);
    for (std::size_t i = 0; i < stress.size(); ++i) stress[i] += from_dw[i];
    pairs.deflections.push_back(std::move(dw));
    pairs.stresses.push_back(std::move(stress));
}

/// Gram and Schmidt, twice, to unit products; one that adds nothing becomes zero.
template <typename Product>
void orthonormalise(std::vector<Vector>& vectors, std::size_t first, Product product) {
    for (std::size_t j = first; j < vectors.size(); ++j) {
        const Real before = product(vectors[j], vectors[j]);
        for (int pass = 0; pass < 2; ++pass) {
            for (std::size_t i = first; i < j; ++i) {
                const Real share = product(vectors[i], vectors[j]);
                for (std::size_t k = 0; k < vectors[j].size(); ++k) vectors[j][k] -= share * vectors[i][k];
            }
        }
        const Real after = product(vectors[j], vectors[j]);
        const Real scale = after > MODE_IS_NEW * before ? 1 / std::sqrt(after) : 0;
        for (Real& v : vectors[j]) v = Real(static_cast<double>(v * scale));
    }
}

void keep_pairs(const Uniform& uniform, const Pairs& pairs, bool with_foundation, Modes& modes) {
    const Padded& grid = uniform.setting->strains.grid();
    std::vector<Vector> strains;
    for (const Vector& w : pairs.deflections) strains.push_back(uniform.strain(w));
    const auto append = [&](std::vector<double>& rows, const Vector& density) {
        const std::vector<double> nodes = nodes_of(grid, density);
        rows.insert(rows.end(), nodes.begin(), nodes.end());
    };
    for (std::size_t i = 0; i < modes.n; ++i) {
        for (std::size_t j = i; j < modes.n; ++j) {
            append(modes.strain_d, bending_at_nodes(grid, strains[i], strains[j]));
            append(modes.stress_d, bending_at_nodes(grid, pairs.stresses[i], pairs.stresses[j]));
            if (!with_foundation) continue;
            append(modes.strain_k, foundation_at_nodes(grid, strains[i], strains[j]));
            append(modes.stress_k, foundation_at_nodes(grid, pairs.stresses[i], pairs.stresses[j]));
        }
    }
}

}  // namespace

Modes make_modes(const Uniform& uniform, const Vector& w0, const Vector& stress0, bool with_foundation) {
    Pairs pairs{{w0}, {stress0}};
    const Setting& setting = *uniform.setting;
    const double side = std::min(setting.unit.size_m.x(), setting.unit.size_m.y());
    for (const auto& p : patterns(side)) add_mode(uniform, w0, pattern(setting, p), pairs);
    if (uniform.k0 > 0) {
        Vector of_foundation(N_KINDS * uniform.n(), Real(0));
        std::fill(of_foundation.begin() + static_cast<std::ptrdiff_t>(FOUNDATION * uniform.n()),
                  of_foundation.end(), Real(1));
        add_mode(uniform, w0, std::move(of_foundation), pairs);
    }
    orthonormalise(pairs.deflections, 0, [&](const Vector& a, const Vector& b) {
        Vector stress = uniform.strain(a);
        uniform.weigh(stress);
        return inner(stress, uniform.strain(b));
    });
    const Vector none(uniform.n(), Real(0));
    const auto product = [&](const Vector& a, const Vector& b) { return uniform.stress_product(a, b); };
    for (std::size_t j = 1; j < pairs.stresses.size(); ++j) uniform.balance(pairs.stresses[j], none);
    orthonormalise(pairs.stresses, 1, product);

    Modes modes;
    modes.n = pairs.deflections.size();
    for (std::size_t i = 0; i < modes.n; ++i) {
        modes.work[i] = static_cast<double>(inner(setting.force, pairs.deflections[i]));
        const Vector slips = uniform.slips(pairs.deflections[i]);
        modes.slip[i] = UP * static_cast<double>(std::sqrt(inner(slips, slips)));
        if (i > 0) uniform.balance(pairs.stresses[i], none);
        modes.imbalance[i] = uniform.imbalance(pairs.stresses[i], i == 0 ? setting.force : none);
    }
    keep_pairs(uniform, pairs, with_foundation, modes);
    return modes;
}

}  // namespace palpate::plate::bounds
