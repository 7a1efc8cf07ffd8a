#include "host/plate/direct/factor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate::plate {
namespace {

constexpr std::size_t BLOCK = 4;  ///< pivots whose columns update the rest together

/// target[i] -= sum_k factors[k] columns[k][i], k ascending for every i.
void subtract_block(double* __restrict__ target, const double* c0, const double* c1, const double* c2,
                    const double* c3, const std::array<double, BLOCK>& f, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        target[i] = (((target[i] - f[0] * c0[i]) - f[1] * c1[i]) - f[2] * c2[i]) - f[3] * c3[i];
    }
}

void subtract(double* __restrict__ target, const double* column, double factor, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) target[i] -= factor * column[i];
}

/// Divides column k of the n x n lower triangle `a` by the root of its pivot. False when the pivot is not
/// positive.
bool scale_pivot(double* a, std::size_t n, std::size_t k) {
    double* const column = a + k * n;
    if (!(column[k] > 0.0)) return false;
    column[k] = std::sqrt(column[k]);
    for (std::size_t i = k + 1; i < n; ++i) column[i] /= column[k];
    return true;
}

/// Cholesky of the first n_pivots columns of the n x n lower triangle `a`; the rest becomes the Schur
/// complement.
bool partial_cholesky(double* a, std::size_t n, std::size_t n_pivots) {
    for (std::size_t k = 0; k < n_pivots; k += BLOCK) {
        const std::size_t end = std::min(k + BLOCK, n_pivots);
        for (std::size_t p = k; p < end; ++p) {
            if (!scale_pivot(a, n, p)) return false;
            for (std::size_t j = p + 1; j < end; ++j) {
                subtract(a + j * n + j, a + p * n + j, a[p * n + j], n - j);
            }
        }
        for (std::size_t j = end; j < n; ++j) {
            double* const target = a + j * n + j;
            const double* const source = a + k * n + j;
            if (end - k == BLOCK) {
                subtract_block(target, source, source + n, source + 2 * n, source + 3 * n,
                               {source[0], source[n], source[2 * n], source[3 * n]}, n - j);
            } else {
                for (std::size_t p = k; p < end; ++p) subtract(target, a + p * n + j, a[p * n + j], n - j);
            }
        }
    }
    return true;
}

/// Adds a child's Schur complement, lower triangle with `in_parent.size()` rows, to its parent's front of n
/// rows.
void extend_add(const std::vector<std::size_t>& in_parent, const double* update, double* a, std::size_t n) {
    const std::size_t m = in_parent.size();
    for (std::size_t j = 0; j < m; ++j) {
        double* const column =
            a + in_parent[j] * n;  // ascending like the child's rows: stays in the lower triangle
        for (std::size_t i = j; i < m; ++i) column[in_parent[i]] += update[j * m + i];
    }
}

}  // namespace

Factor::Factor(std::shared_ptr<const Analysis> analysis, std::span<const double> values)
    : analysis_(std::move(analysis)),
      panels_(std::make_unique_for_overwrite<double[]>(analysis_->n_factor)),
      smallest_pivot_ratio_(1.0) {
    const std::size_t n_work = analysis_->largest_front * analysis_->largest_front;
    const auto memory = std::make_unique_for_overwrite<double[]>(n_work + analysis_->n_waiting);
    double* updates_end = memory.get() + n_work;
    for (const Front& front : analysis_->fronts) {
        if (eliminate(front, values, memory.get(), updates_end)) continue;
        smallest_pivot_ratio_ = -1.0;
        return;
    }
}

bool Factor::eliminate(const Front& front, std::span<const double> values, double* work,
                       double*& updates_end) {
    const Analysis& analysis = *analysis_;
    const std::size_t n = front.rows.size();
    std::fill_n(work, n * n, 0.0);
    for (std::size_t k = 0; k < front.n_pivots; ++k) {
        const std::size_t column = front.first + k;
        for (std::size_t e = analysis.column[column]; e < analysis.column[column + 1]; ++e) {
            work[k * n + analysis.front_row[e]] = values[e];
        }
    }
    for (auto child = front.children.rbegin(); child != front.children.rend(); ++child) {
        const std::vector<std::size_t>& in_parent = analysis.fronts[*child].in_parent;
        updates_end -= in_parent.size() * in_parent.size();
        extend_add(in_parent, updates_end, work, n);
    }
    if (!partial_cholesky(work, n, front.n_pivots)) return false;
    keep(front, values, work);
    for (std::size_t j = front.n_pivots; j < n; ++j) {
        updates_end = std::copy(work + j * n + front.n_pivots, work + (j + 1) * n, updates_end);
    }
    return true;
}

void Factor::keep(const Front& front, std::span<const double> values, const double* work) {
    const std::size_t n = front.rows.size();
    std::copy_n(work, n * front.n_pivots, panels_.get() + front.panel);
    for (std::size_t k = 0; k < front.n_pivots; ++k) {
        const double diagonal = values[analysis_->column[front.first + k]];
        const double ratio = work[k * n + k] * work[k * n + k] / diagonal;
        if (!(ratio >= smallest_pivot_ratio_)) smallest_pivot_ratio_ = ratio;
    }
}

double Factor::last_compliance() const {
    const Front& root = analysis_->fronts.back();
    const std::size_t last = root.n_pivots - 1;  // the root has no border
    const double pivot = panels_[root.panel + last * root.rows.size() + last];
    return 1.0 / (pivot * pivot);
}

void Factor::solve(std::span<double> x) const {
    for (const Front& front : analysis_->fronts) {
        const std::size_t n = front.rows.size();
        for (std::size_t k = 0; k < front.n_pivots; ++k) {
            const double* const column = panels_.get() + front.panel + k * n;
            const double y = x[front.first + k] / column[k];
            x[front.first + k] = y;
            for (std::size_t i = k + 1; i < n; ++i) x[front.rows[i]] -= column[i] * y;
        }
    }
    for (auto front = analysis_->fronts.rbegin(); front != analysis_->fronts.rend(); ++front) {
        const std::size_t n = front->rows.size();
        for (std::size_t k = front->n_pivots; k-- > 0;) {
            const double* const column = panels_.get() + front->panel + k * n;
            double sum = x[front->first + k];
            for (std::size_t i = k + 1; i < n; ++i) sum -= column[i] * x[front->rows[i]];
            x[front->first + k] = sum / column[k];
        }
    }
}

}  // namespace palpate::plate
