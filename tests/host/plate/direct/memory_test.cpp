#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "host/plate/batch.hpp"
#include "host/plate/plate.hpp"
#include "tests/host/plate/counting_heap.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

template <typename Call>
long allocations_of(Call&& call) {
    const long before = n_allocations();
    call();
    return n_allocations() - before;
}

TEST_CASE("a plate that is made allocates no more, nor does a batch") {
    const Kernel kernel = GENERATE(as<Kernel>{}, Kernel::portable, Kernel::best);
    const Problem problem = fields::unit_square(33, fields::hyper10);
    const Eigen::ArrayXXd another = fields::unit_square(33, fields::wart).rigidity_n_m;
    CHECK(allocations_of([&] { static_cast<void>(Plate(problem, kernel)); }) > 0);  // the counter counts
    Plate plate(problem, kernel);
    Batch batch(problem, kernel);
    const std::vector<Node> nodes{{16, 16}, {3, 5}, {0, 0}, {20, 9}};
    std::vector<double> compliances(nodes.size()), field(33 * 33), force(33 * 33, 1.0), lanes(batch.lanes());
    CHECK(allocations_of([&] { plate.set_rigidity(another); }) == 0);
    CHECK(allocations_of([&] { plate.compliances_m_per_n(nodes, compliances); }) == 0);
    CHECK(allocations_of([&] { compliances[0] = plate.compliance_m_per_n({7, 8}); }) == 0);
    CHECK(allocations_of([&] { compliances[0] = plate.centre_compliance_m_per_n(); }) == 0);
    CHECK(allocations_of([&] { plate.deflection_m(nodes[1], field); }) == 0);
    CHECK(allocations_of([&] { plate.solve(force, field); }) == 0);
    CHECK(allocations_of([&] {
              for (std::size_t lane = 0; lane < lanes.size(); ++lane) batch.set_rigidity(lane, another);
              batch.centre_compliances_m_per_n(lanes);
          }) == 0);
    CHECK(lanes[0] == Approx(compliances[0]).epsilon(1e-11));
}

TEST_CASE("another rigidity gives what a new plate gives, bit for bit") {
    const Kernel kernel = GENERATE(as<Kernel>{}, Kernel::portable, Kernel::best);
    Plate plate(fields::unit_square(33, fields::hyper10), kernel);
    const Problem another = fields::unit_square(33, fields::wart);
    plate.set_rigidity(another.rigidity_n_m);
    const Plate fresh(another, kernel);
    CHECK(plate.centre_compliance_m_per_n() == fresh.centre_compliance_m_per_n());
    CHECK((plate.deflection_m(5, 9) == fresh.deflection_m(5, 9)).all());
    std::vector<double> every(33 * 33);
    std::vector<Node> nodes;
    for (Eigen::Index k = 0; k < 33 * 33; ++k) nodes.push_back({k % 33, k / 33});
    plate.compliances_m_per_n(nodes, every);
    for (std::size_t k = 0; k < nodes.size(); k += 37) {
        const double wanted = fresh.deflection_m(nodes[k].ix, nodes[k].iz)(nodes[k].ix, nodes[k].iz);
        CHECK(every[k] == Approx(wanted).epsilon(1e-10).margin(1e-18));
    }
}

TEST_CASE("a plate without a rigidity that it can be solved with answers nothing until it has one") {
    Plate plate(fields::unit_square(17, fields::hyper10));
    const double before = plate.centre_compliance_m_per_n();
    std::vector<double> field(17 * 17);
    for (const double bad : {-1.0, 0.0, std::nan(""), HUGE_VAL}) {
        Eigen::ArrayXXd rigidity = fields::unit_square(17, fields::hyper10).rigidity_n_m;
        rigidity(3, 11) = bad;
        CHECK_THROWS_AS(plate.set_rigidity(rigidity), Guard);
        CHECK_THROWS_AS(plate.centre_compliance_m_per_n(), Guard);
        CHECK_THROWS_AS(plate.compliance_m_per_n({4, 4}), Guard);
        CHECK_THROWS_AS(plate.deflection_m({4, 4}, field), Guard);
        CHECK_THROWS_AS(plate.solve(field, field), Guard);
    }
    plate.set_rigidity(fields::unit_square(17, fields::hyper10).rigidity_n_m);
    CHECK(plate.centre_compliance_m_per_n() == before);
}

TEST_CASE("two threads ask one plate at the same time") {
    const Plate plate(fields::unit_square(33, fields::hyper10), Kernel::best);
    const double wanted = plate.compliance_m_per_n({5, 9});
    std::atomic<int> n_wrong{0};
    const auto ask = [&] {
        for (int k = 0; k < 2000; ++k) {
            if (plate.compliance_m_per_n({5, 9}) != wanted) ++n_wrong;
        }
    };
    std::thread other(ask);
    ask();
    other.join();
    CHECK(n_wrong == 0);
}

TEST_CASE("portable numbers are these bits, from every compiler at every level") {
    const Plate plate(fields::unit_square(33, fields::hyper10));
    CHECK(std::string(plate.kernel()) == "baseline");
    CHECK(plate.centre_compliance_m_per_n() == 0x1.6deca77120016p-9);
    CHECK(plate.compliance_m_per_n({9, 20}) == 0x1.1860b83cf2dc1p-10);
    CHECK(plate.deflection_m(9, 20)(25, 7) == 0x1.b3f25945445a5p-14);
}

}  // namespace
}  // namespace palpate::plate
