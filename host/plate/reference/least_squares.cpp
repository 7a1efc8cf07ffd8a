#include "host/plate/reference/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace palpate::reference {
namespace {

constexpr double WORK_LIMIT = 1e-5;

double sum_of(const Terms& terms, double const* const* unknowns) {
    double sum = 0.0;
    for (const Term& term : terms) sum += term.factor * unknowns[term.unknown][0];
    return sum;
}

/// Terms are by place in the block's own list of unknowns.
class Block final : public ceres::CostFunction {
public:
    Block(std::vector<Residual> residuals, std::size_t unknowns) : residuals_(std::move(residuals)) {
        set_num_residuals(static_cast<int>(residuals_.size()));
        mutable_parameter_block_sizes()->assign(unknowns, 1);
    }

    bool Evaluate(double const* const* unknowns, double* residuals, double** jacobians) const override {
        if (jacobians != nullptr) clear(jacobians);
        for (std::size_t r = 0; r < residuals_.size(); ++r) {
            residuals[r] = sum_of(residuals_[r].linear, unknowns);
            add_slopes(jacobians, r, residuals_[r].linear, 1.0);
            for (const Product& product : residuals_[r].products) {
                const double first = sum_of(product.first, unknowns);
                const double second = sum_of(product.second, unknowns);
                residuals[r] += first * second;
                add_slopes(jacobians, r, product.first, second);
                add_slopes(jacobians, r, product.second, first);
            }
        }
        return true;
    }

private:
    void clear(double** jacobians) const {
        for (std::size_t k = 0; k < parameter_block_sizes().size(); ++k) {
            if (jacobians[k] != nullptr) std::fill_n(jacobians[k], residuals_.size(), 0.0);
        }
    }
    static void add_slopes(double** jacobians, std::size_t r, const Terms& terms, double factor) {
        if (jacobians == nullptr) return;
        for (const Term& term : terms) {
            if (jacobians[term.unknown] != nullptr) jacobians[term.unknown][r] += factor * term.factor;
        }
    }

    std::vector<Residual> residuals_;
};

/// `terms` by place in `used`, which grows.
Terms placed(const Terms& terms, std::vector<Unknown>& used) {
    Terms out;
    for (const Term& term : terms) {
        if (term.unknown == ZERO || term.factor == 0.0) continue;
        const auto found = std::find(used.begin(), used.end(), term.unknown);
        out.push_back({static_cast<std::size_t>(found - used.begin()), term.factor});
        if (found == used.end()) used.push_back(term.unknown);
    }
    return out;
}

ceres::Solver::Options solver_options() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.initial_trust_region_radius = 1e16;  // a linear problem needs no damping
    options.max_num_iterations = 2000;           // residuals' curvature, which Ceres drops, costs many
    options.function_tolerance = 1e-18;
    options.gradient_tolerance = 1e-15;
    options.parameter_tolerance = 1e-15;
    options.logging_type = ceres::SILENT;
    return options;
}

}  // namespace

void LeastSquares::add(const std::vector<Residual>& residuals) {
    std::vector<Unknown> used;
    std::vector<Residual> local(residuals.size());
    for (std::size_t r = 0; r < residuals.size(); ++r) {
        local[r].linear = placed(residuals[r].linear, used);
        for (const Product& product : residuals[r].products) {
            Product mine{placed(product.first, used), placed(product.second, used)};
            if (!mine.first.empty() && !mine.second.empty()) local[r].products.push_back(std::move(mine));
        }
    }
    if (used.empty()) return;
    std::vector<double*> unknowns;
    unknowns.reserve(used.size());
    for (const Unknown unknown : used) unknowns.push_back(&values_[unknown]);
    // The problem owns the block.
    problem_.AddResidualBlock(new Block(std::move(local), used.size()), nullptr, unknowns);
}

Minimum LeastSquares::measured(Unknown held) {
    std::vector<double*> unknowns;
    problem_.GetParameterBlocks(&unknowns);
    Minimum minimum;
    std::vector<double> gradient;
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = unknowns;  // in this order: by default it is another
    problem_.Evaluate(options, &minimum.energy, nullptr, &gradient, nullptr);
    double work = 0.0;  // of what is left of the derivatives
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
        if (unknowns[k] == &values_[held]) {
            minimum.reaction = gradient[k];
        } else {
            work += std::abs(gradient[k] * *unknowns[k]);
        }
    }
    const double left = work / std::abs(minimum.reaction * values_[held]);
    if (!(left <= WORK_LIMIT)) {
        std::ostringstream words;
        words << "no minimum: " << left << " of the reaction's work is left over";
        throw std::runtime_error(words.str());
    }
    return minimum;
}

Minimum LeastSquares::minimise(Unknown held) {
    problem_.SetParameterBlockConstant(&values_[held]);
    ceres::Solver::Summary summary;
    ceres::Solve(solver_options(), &problem_, &summary);
    problem_.SetParameterBlockVariable(&values_[held]);
    if (!summary.IsSolutionUsable()) throw std::runtime_error("no solution: " + summary.message);
    Minimum minimum = measured(held);
    minimum.iterations = static_cast<int>(summary.iterations.size());
    return minimum;
}

}  // namespace palpate::reference
