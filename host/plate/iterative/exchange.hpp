/// Between arrays over the nodes of a grid and vectors in a stencil's layout, with the checks that every
/// method makes.
#pragma once
#include <Eigen/Core>
#include <span>

#include "host/plate/problem.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {

/// Throws std::invalid_argument unless D has the layout's size, Guard unless it is positive, finite and
/// within 15 decades where there is plate. Does not allocate when all is well.
void require_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m, const Layout& layout,
                      const Mask& solid);

/// Forces at the nodes that move into the layout; the rest of `f` stays. Returns max |f|. Throws
/// std::invalid_argument on a wrong size, Guard on a force that is not finite.
double put_force(const Stencil& stencil, std::span<const double> force_n, double* f);
/// Solution of K x = f to deflections in m, 0 where nothing moves. Throws std::invalid_argument on a wrong
/// size.
void take_deflection(const Stencil& stencil, const double* x, std::span<double> deflection_m);

/// max |r_i| of n numbers; infinite when one is not finite.
[[nodiscard]] double largest(std::span<const double> r);
/// max |K x - f|/f_max, infinite when it is not finite. `r` is room for a vector.
[[nodiscard]] double true_residual(const Stencil& stencil, const double* x, const double* f, double f_max,
                                   std::span<double> r);

/// Throws Guard "`method` gives a negative compliance ..." unless the work f'x of forces that are not all
/// zero is positive.
void require_work(const Stencil& stencil, const double* x, const double* f, const char* method);

}  // namespace palpate::plate
