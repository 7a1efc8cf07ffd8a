// Counts what a thread allocates: malloc itself, as Eigen does not go by operator new.
#include <catch2/catch.hpp>
#include <cstddef>
#include <memory>
#include <vector>

#include "tests/host/plate/methods/forces.hpp"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {
thread_local long n_allocations = 0;
}

// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): glibc's names
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
    ++n_allocations;
    return __libc_malloc(size);
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

namespace palpate::plate {
namespace {

using namespace fields;

template <typename Call>
long allocations_of(Call&& call) {
    const long before = n_allocations;
    call();
    return n_allocations - before;
}

TEST_CASE("the counter of allocations counts") {
    CHECK(allocations_of([] {}) == 0);
    std::unique_ptr<int> kept;
    CHECK(allocations_of([&] { kept = std::make_unique<int>(1); }) == 1);
    std::vector<double> more;
    CHECK(allocations_of([&] { more.resize(1000); }) == 1);
    const Eigen::ArrayXXd ones = Eigen::ArrayXXd::Ones(50, 50);
    Eigen::ArrayXXd twos;
    CHECK(allocations_of([&] { twos = ones + ones; }) == 1);
    // The methods that do allocate: their calls are seen.
    const Problem problem = unit_square(9, one);
    const auto eigen = make_solver(Method::eigen, problem);
    CHECK(allocations_of([&] { eigen->set_rigidity(problem.rigidity_n_m); }) > 0);
}

TEST_CASE("multigrid and Jacobi allocate nothing once they are made") {
    const Method method = GENERATE(as<Method>{}, Method::multigrid, Method::jacobi, Method::damped_jacobi);
    const Kernel kernel = GENERATE(as<Kernel>{}, Kernel::portable, Kernel::best);
    const bool hole = GENERATE(as<bool>{}, false, true);
    Problem problem = on_foundation(unit_square(33, gauss), 8.0);
    if (hole) problem.solid = sampled(33, [](double x, double) { return 0.7 - x; }) > 0.0;
    const Eigen::ArrayXXd rigidity_n_m = sampled(33, hyper10);
    const auto solver = make_solver(method, problem, {.sweeps_max = 100, .kernel = kernel});
    const std::vector<double> force_n = forces::at_centre(problem);
    std::vector<double> deflection_m(force_n.size());
    CHECK(allocations_of([&] { solver->set_rigidity(rigidity_n_m); }) == 0);
    CHECK(allocations_of([&] { static_cast<void>(solver->solve(force_n, deflection_m)); }) == 0);
}

TEST_CASE("Cholesky takes another rigidity without allocating") {
    const Problem problem = unit_square(33, gauss);
    const auto solver = make_solver(Method::cholesky, problem);
    const Eigen::ArrayXXd rigidity_n_m = sampled(33, hyper10);
    CHECK(allocations_of([&] { solver->set_rigidity(rigidity_n_m); }) == 0);
}

}  // namespace
}  // namespace palpate::plate

#endif
