#include "host/plate/uniform/closed_form.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "host/plate/plate.hpp"
#include "host/plate/uniform/green.hpp"

namespace palpate::plate {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

constexpr std::array<Edge, 4> SUPPORTED{Edge::supported, Edge::supported, Edge::supported, Edge::supported};

/// D = 1, a/l = `side_over_l` for side 1.
UniformPlate plate_of(const Vector2d& size, double side_over_l = 0.0, const std::array<Edge, 4>& edges = {}) {
    const double s2 = side_over_l * side_over_l;
    return {.size_m = size, .rigidity_n_m = 1.0, .foundation_n_per_m3 = s2 * s2, .edges = edges};
}

double compliance(const UniformPlate& plate, const Vector2d& at) {
    return UniformSolution(plate, {at}).compliance().m_per_n;
}

double at_centre(const UniformPlate& plate) {
    return compliance(plate, 0.5 * plate.size_m);
}

/// Every way to clamp or support four edges.
std::vector<std::array<Edge, 4>> all_edges() {
    std::vector<std::array<Edge, 4>> all;
    for (unsigned bits = 0; bits < 16; ++bits) {
        std::array<Edge, 4> edges{};
        for (unsigned k = 0; k < 4; ++k)
            if ((bits >> k & 1U) != 0) edges[k] = Edge::supported;
        all.push_back(edges);
    }
    return all;
}

/// Abscissae in (0, 1) and weights of Gauss and Legendre, by Newton's method.
struct Gauss {
    std::vector<double> x, weight;

    explicit Gauss(int n) {
        for (int i = 0; i < n; ++i) {
            double t = std::cos(pi * (i + 0.75) / (n + 0.5)), slope = 0.0;
            for (int step = 0; step < 20; ++step) {
                double p = 1.0, before = 0.0;
                for (int k = 1; k <= n; ++k) {
                    const double next = ((2.0 * k - 1.0) * t * p - (k - 1.0) * before) / k;
                    before = p;
                    p = next;
                }
                slope = n * (t * p - before) / (t * t - 1.0);
                t -= p / slope;
            }
            x.push_back(0.5 * (1.0 + t));
            weight.push_back(1.0 / ((1.0 - t * t) * slope * slope));
        }
    }
};

/// Mean of f over the disc.
template <typename Function>
double mean_over_disc(const Vector2d& centre, double radius, Function f) {
    constexpr int N_AROUND = 32;
    const Gauss gauss(12);
    double sum = 0.0;
    for (std::size_t i = 0; i < gauss.x.size(); ++i) {
        for (int k = 0; k < N_AROUND; ++k) {
            const double turn = 2.0 * pi * (k + 0.3) / N_AROUND, rho = radius * gauss.x[i];
            sum += gauss.weight[i] * 2.0 * gauss.x[i] / N_AROUND *
                   f(Vector2d(centre + rho * Vector2d(std::cos(turn), std::sin(turn))));
        }
    }
    return sum;
}

TEST_CASE("the closed form meets the published deflections of clamped rectangles") {
    // Biharmonic least squares of degree 80-100: half a unit of the last digit given.
    struct Anchor {
        Vector2d size, load;
        double there, there_margin, centre, centre_margin;
    };
    const std::vector<Anchor> anchors{
        {{1, 1}, {0.5, 0.5}, 0.005612024020, 6e-13, 0.005612024020, 6e-13},
        {{1, 1}, {0.75, 0.5}, 0.0032855433, 6e-11, 0.0024684514, 6e-11},
        {{1, 1}, {0.75, 0.75}, 0.002283363, 6e-10, 0.001225881, 6e-10},
        {{1, 1}, {0.625, 0.625}, 0.0045083411, 6e-11, 0.0036376382, 6e-11},
        {{1, 1}, {0.6, 0.7}, 0.0038651484, 6e-11, 0.0029109245, 6e-11},
        {{1, 2}, {0.5, 1.0}, 0.0072305563, 6e-11, 0.0072305563, 6e-11},
        {{1, 1.5}, {0.5, 0.75}, 0.0070428578, 6e-11, 0.0070428578, 6e-11},
        {{1, 10}, {0.5, 5.0}, 0.0072425, 5e-8, 0.0072425, 5e-8},
    };
    for (const Anchor& anchor : anchors) {
        CAPTURE(anchor.size.transpose(), anchor.load.transpose());
        const UniformPlate plate = plate_of(anchor.size);
        const UniformSolution solution(plate, {anchor.load});
        CHECK(solution.compliance().m_per_n == Approx(anchor.there).margin(anchor.there_margin).epsilon(0));
        CHECK(solution.compliance().relative_error < 1e-10);
        CHECK(solution.deflection_m_per_n(anchor.load) ==
              Approx(solution.compliance().m_per_n).epsilon(1e-13));
        CHECK(solution.deflection_m_per_n(0.5 * anchor.size) ==
              Approx(anchor.centre).margin(anchor.centre_margin).epsilon(0));
    }
}

TEST_CASE("the closed form meets Timoshenko's table of simply supported rectangles") {
    // Theory of Plates and Shells, article 34: w = alpha P a^2/D, load at the centre.
    const std::vector<std::pair<double, double>> table{
        {1.0, 0.01160}, {1.1, 0.01265}, {1.2, 0.01353}, {1.4, 0.01484},
        {1.6, 0.01570}, {1.8, 0.01620}, {2.0, 0.01651}, {3.0, 0.01690},
    };
    for (const auto& [longer, alpha] : table) {
        CAPTURE(longer);
        const double c = at_centre(plate_of({1.0, longer}, 0.0, SUPPORTED));
        CHECK(c == Approx(alpha).epsilon(2.1e-3));  // as far as the table is right
        // The formula that the table is from: (1/2 pi^3) sum over odd m of (tanh b - b/cosh^2 b)/m^3.
        double sum = 0.875 * 1.2020569031595942;
        for (int m = 1; m < 60; m += 2) {
            const double b = 0.5 * m * pi * longer, sech = 1.0 / std::cosh(b);
            sum -= (2.0 / (1.0 + std::exp(2.0 * b)) + b * sech * sech) / (m * m * m);
        }
        CHECK(c == Approx(sum / (2.0 * pi * pi * pi)).epsilon(1e-12));
    }
    CHECK(at_centre(plate_of({1.0, 1.0}, 0.0, SUPPORTED)) == Approx(0.0116008).margin(5e-8));
}

TEST_CASE("a plate twenty times as long as wide is the infinite strip") {
    // Fourier integral along the strip, real hyperbolic functions; beyond LAST the integrand is 1/(4 t^3).
    constexpr double STEP = 0.005, LAST = 60.0;
    double supported = 1.0 / (8.0 * pi * LAST * LAST), clamped = supported;
    for (double t = 0.5 * STEP; t < LAST; t += STEP) {
        const double tanh = std::tanh(0.5 * t), sech = 1.0 / std::cosh(0.5 * t);
        const double held = tanh / (4.0 * t * t * t) - sech * sech / (8.0 * t * t);
        const double by_moment = sech * tanh / (4.0 * t);
        const double slope = (tanh + 0.5 * t * sech * sech) / (2.0 * t);
        supported += STEP / pi * held;
        clamped += STEP / pi * (held - by_moment * by_moment / (2.0 * slope));
    }
    CHECK(supported == Approx(7.0 * 1.2020569031595942 / (16.0 * pi * pi * pi)).epsilon(1e-10));
    CHECK(at_centre(plate_of({1.0, 20.0}, 0.0, SUPPORTED)) == Approx(supported).epsilon(1e-9));
    CHECK(at_centre(plate_of({20.0, 1.0})) == Approx(clamped).epsilon(1e-9));
    CHECK(at_centre(plate_of({20.0, 1.0}, 0.0, {Edge::supported, Edge::clamped})) ==
          Approx(clamped).epsilon(1e-9));
}

TEST_CASE("on a foundation the closed form is the table of the uniform square, and 1/8 far from the edges") {
    for (const double s : {0.0, 0.5, 1.0, 3.0, 4.5, 7.7, 11.3, 15.0, 19.5, 23.9}) {
        CAPTURE(s);
        CHECK(at_centre(plate_of({1.0, 1.0}, s)) == Approx(uniform_square_compliance(s)).epsilon(1e-9));
    }
    for (const auto& edges : all_edges()) {
        CHECK(50.0 * 50.0 * at_centre(plate_of({1.0, 1.0}, 50.0, edges)) == Approx(0.125).epsilon(1e-10));
        CHECK(50.0 * 50.0 * at_centre(plate_of({1.0, 10.0}, 50.0, edges)) == Approx(0.125).epsilon(1e-10));
    }
}

TEST_CASE("a weak foundation changes nothing: no digits are lost on the way to none") {
    const Vector2d at{0.3, 0.6};
    const double bare = compliance(plate_of({1.0, 1.0}), at);
    for (const double s : {1e-6, 1e-4, 1e-2, 0.1}) {
        CAPTURE(s);
        const double softer = bare - compliance(plate_of({1.0, 1.0}, s), at);
        CHECK(std::fabs(softer) < bare * (1e-13 + std::pow(s, 4) / 1294.9));  // 1294.9: first eigenvalue
    }
}

TEST_CASE("a supported edge is the middle of a plate twice as long with a second load, pulling") {
    const Vector2d load{0.35, 0.8}, at{0.7, 0.45}, size{1.0, 1.3};
    for (const auto& edges : all_edges()) {
        for (std::size_t k = 0; k < 4; ++k) {
            if (edges[k] != Edge::supported) continue;
            const Eigen::Index axis = k / 2 == 0 ? 0 : 1;
            const std::size_t other = k ^ 1U;
            auto doubled_edges = edges;
            doubled_edges[k] = edges[other];
            Vector2d doubled_size = size, shift = Vector2d::Zero();
            doubled_size[axis] *= 2.0;
            if (k % 2 == 0) shift[axis] = size[axis];  // supported at the low end: the copy lies below
            Vector2d image = load + shift;
            image[axis] = doubled_size[axis] - image[axis];
            for (const double s : {0.0, 6.0}) {
                CAPTURE(k, s, edges[0], edges[1], edges[2], edges[3]);
                const UniformSolution one(plate_of(size, s, edges), {load});
                const UniformPlate doubled = plate_of(doubled_size, s, doubled_edges);
                const UniformSolution push(doubled, {load + shift}), pull(doubled, {image});
                const auto both = [&](const Vector2d& x) {
                    return push.deflection_m_per_n(x + shift) - pull.deflection_m_per_n(x + shift);
                };
                CHECK(one.deflection_m_per_n(at) == Approx(both(at)).epsilon(1e-9));
                CHECK(one.compliance().m_per_n == Approx(both(load)).epsilon(1e-10));
            }
        }
    }
}

TEST_CASE("cause and effect, the axes and the ends can be exchanged") {
    const Vector2d size{1.0, 1.4}, a{0.2, 0.9}, b{0.65, 0.3};
    for (const auto& edges : all_edges()) {
        CAPTURE(edges[0], edges[1], edges[2], edges[3]);
        const UniformPlate plate = plate_of(size, 4.0, edges);
        const double w = UniformSolution(plate, {a}).deflection_m_per_n(b);
        CHECK(UniformSolution(plate, {b}).deflection_m_per_n(a) == Approx(w).epsilon(1e-9));
        const UniformPlate turned =
            plate_of({size.y(), size.x()}, 4.0, {edges[2], edges[3], edges[0], edges[1]});
        CHECK(UniformSolution(turned, {{a.y(), a.x()}}).deflection_m_per_n({b.y(), b.x()}) ==
              Approx(w).epsilon(1e-12));
        const UniformPlate mirrored = plate_of(size, 4.0, {edges[1], edges[0], edges[2], edges[3]});
        CHECK(UniformSolution(mirrored, {{size.x() - a.x(), a.y()}})
                  .deflection_m_per_n({size.x() - b.x(), b.y()}) == Approx(w).epsilon(1e-12));
    }
}

TEST_CASE("edges hold: no deflection on any, no slope on the clamped ones") {
    for (const auto& edges : all_edges()) {
        CAPTURE(edges[0], edges[1], edges[2], edges[3]);
        const UniformSolution solution(plate_of({1.0, 1.0}, 0.0, edges), {{0.6, 0.55}});
        const double depth = solution.compliance().m_per_n, step = 1e-3;
        const std::array<Vector2d, 4> on{{{0, 0.4}, {1, 0.4}, {0.4, 0}, {0.4, 1}}};
        const std::array<Vector2d, 4> inward{{{step, 0}, {-step, 0}, {0, step}, {0, -step}}};
        for (std::size_t k = 0; k < 4; ++k) {
            CHECK(std::fabs(solution.deflection_m_per_n(on[k])) < 1e-12 * depth);
            const double near = solution.deflection_m_per_n(on[k] + inward[k]);
            const double far = solution.deflection_m_per_n(on[k] + 2.0 * inward[k]);
            // Deflection grows with the square of the distance, or with it.
            CHECK(far / near == Approx(edges[k] == Edge::clamped ? 4.0 : 2.0).epsilon(0.01));
        }
    }
}

TEST_CASE("beside a clamped edge the plate is a clamped half plane, 1/(4 pi) of the distance squared") {
    for (const double distance : {0.02, 0.01, 0.005}) {
        CAPTURE(distance);
        const ClosedForm c = UniformSolution(plate_of({1.0, 1.0}), {{0.5, distance}}).compliance();
        CHECK(c.m_per_n / (distance * distance) == Approx(0.25 / pi).epsilon(10.0 * distance * distance));
        CHECK(c.relative_error < 1e-7);
    }
}

TEST_CASE("the error told near a corner is the true one or more") {
    // A corner has no length: c is distance^2 times a number, up to distance^5.5 from the plate's size.
    const auto scaled = [](double distance) {
        const ClosedForm c = UniformSolution(plate_of({1.0, 1.0}), {{distance, distance}}).compliance();
        return std::pair(c.m_per_n / (distance * distance), c.relative_error);
    };
    const auto [number, sure] = scaled(0.02);
    CHECK(sure < 1e-9);
    for (const double distance : {0.005, 0.0025, 0.00125}) {
        CAPTURE(distance);
        const auto [here, told] = scaled(distance);
        const double wrong = std::fabs(here / number - 1.0);
        CHECK(wrong > 1e-7);  // or it would prove nothing
        CHECK(wrong < told);
        CHECK(told < 100.0 * wrong);
    }
    CHECK(scaled(0.0002).second > 0.5);  // no wave is short enough: nothing is claimed
}

TEST_CASE("a disc is what loads all over it add up to") {
    const Vector2d centre{0.45, 0.6};
    const auto [s, radius] = GENERATE(as<std::pair<double, double>>{}, std::pair(0.0, 0.25),
                                      std::pair(6.0, 0.1), std::pair(20.0, 0.25));
    const auto edges = GENERATE(as<std::array<Edge, 4>>{}, std::array<Edge, 4>{},
                                std::array{Edge::supported, Edge::clamped, Edge::clamped, Edge::supported});
    CAPTURE(radius, edges[0]);
    const UniformPlate plate = plate_of({1.0, 1.2}, s, edges);
    const UniformSolution disc(plate, {centre, radius});

    // Outside: deflection there under loads over the disc, which is that over the disc under a load there.
    const Vector2d outside{0.8, 0.3};
    const UniformSolution point(plate, {outside});
    const auto by_point = [&](const Vector2d& x) { return point.deflection_m_per_n(x); };
    const double w = mean_over_disc(centre, radius, by_point);
    CHECK(disc.deflection_m_per_n(outside) == Approx(w).epsilon(1e-8).margin(1e-13));
    // At the centre: the same sum, over a kernel with a kink there.
    const UniformSolution middle(plate, {centre});
    const auto by_middle = [&](const Vector2d& x) { return middle.deflection_m_per_n(x); };
    CHECK(disc.deflection_m_per_n(centre) == Approx(mean_over_disc(centre, radius, by_middle)).epsilon(2e-6));
    // The mean of the disc's own deflections.
    const auto by_disc = [&](const Vector2d& x) { return disc.deflection_m_per_n(x); };
    CHECK(disc.compliance().m_per_n == Approx(mean_over_disc(centre, radius, by_disc)).epsilon(1e-8));
    CHECK(disc.compliance().relative_error < 1e-9);
    // One law inside and out.
    const Vector2d rim = centre + radius * Vector2d(0.6, 0.8), step = 1e-9 * Vector2d(0.6, 0.8);
    CHECK(disc.deflection_m_per_n(rim - step) == Approx(disc.deflection_m_per_n(rim + step)).epsilon(1e-6));
}

TEST_CASE("the smaller the disc the nearer to a point") {
    const UniformPlate plate = plate_of({1.0, 1.0}, 3.0);
    const double point = at_centre(plate);
    double last = 0.0;
    for (const double radius : {0.2, 0.02, 0.002, 0.00002}) {
        const double c = UniformSolution(plate, {{0.5, 0.5}, radius}).compliance().m_per_n;
        CHECK(c > last);
        CHECK(c < point);
        last = c;
    }
    CHECK(last == Approx(point).epsilon(1e-6));
}

TEST_CASE("sizes and rigidity scale as a^2/D") {
    const double side = 0.04, rigidity = 8.7e-5, s = 13.5;
    const UniformPlate plate{.size_m = {side, 2.0 * side},
                             .rigidity_n_m = rigidity,
                             .foundation_n_per_m3 = rigidity * std::pow(s / side, 4),
                             .edges = {}};
    const double unit = compliance(plate_of({1.0, 2.0}, s), {0.4, 0.7});
    CHECK(compliance(plate, {0.4 * side, 0.7 * side}) ==
          Approx(unit * side * side / rigidity).epsilon(1e-12));
}

TEST_CASE("the polylogarithms meet their values at 1, -1, 1/2 and on the unit circle") {
    const double zeta_3 = 1.2020569031595942, ln2 = std::log(2.0);
    CHECK(polylog(0.0).li2.real() == Approx(pi * pi / 6.0).epsilon(1e-15));
    CHECK(polylog(0.0).li3.real() == Approx(zeta_3).epsilon(1e-15));
    CHECK(polylog({0.0, pi}).li2.real() == Approx(-pi * pi / 12.0).epsilon(1e-14));
    CHECK(polylog({0.0, pi}).li3.real() == Approx(-0.75 * zeta_3).epsilon(1e-14));
    CHECK(polylog(-ln2).li2.real() == Approx(pi * pi / 12.0 - ln2 * ln2 / 2.0).epsilon(1e-14));
    CHECK(polylog(-ln2).li3.real() ==
          Approx(ln2 * ln2 * ln2 / 6.0 - pi * pi * ln2 / 12.0 + 0.875 * zeta_3).epsilon(1e-14));
    for (const double t : {0.3, 1.7, 3.0}) {  // Fourier series of parabola and cubic
        CHECK(polylog({0.0, t}).li2.real() ==
              Approx(pi * pi / 6.0 - pi * t / 2.0 + t * t / 4.0).epsilon(1e-13));
        CHECK(polylog({0.0, t}).li3.imag() ==
              Approx(pi * pi * t / 6.0 - pi * t * t / 4.0 + t * t * t / 12.0).epsilon(1e-13));
    }
    for (const double re : {-1.0, -1.49, -1.51, -4.0}) {  // both sides of the seam, against the plain series
        for (const double im : {0.0, 1.0, 3.1}) {
            const std::complex<double> q = std::exp(std::complex<double>(re, im));
            std::complex<double> li2 = 0.0, li3 = 0.0, power = q;
            for (int k = 1; k < 60; ++k, power *= q) {
                li2 += power / (1.0 * k * k);
                li3 += power / (1.0 * k * k * k);
            }
            CAPTURE(re, im);
            CHECK(std::abs(polylog({re, im}).li2 - li2) < 1e-15);
            CHECK(std::abs(polylog({re, im}).li3 - li3) < 1e-15);
        }
    }
}

TEST_CASE("a free edge has no closed form, and what cannot be is refused") {
    UniformPlate plate = plate_of({1.0, 1.0});
    CHECK_NOTHROW(UniformSolution(plate, {{0.5, 0.5}}));
    const std::size_t k = GENERATE(as<std::size_t>{}, 0, 1, 2, 3);
    plate.edges[k] = Edge::free;
    CHECK_THROWS_AS(UniformSolution(plate, {{0.5, 0.5}}), std::invalid_argument);

    const double nan = std::nan("");
    const UniformPlate good = plate_of({1.0, 1.0}, 10.0);
    const auto refused = [](const UniformPlate& bad, const UniformLoad& load) {
        CHECK_THROWS_AS(UniformSolution(bad, load), std::invalid_argument);
    };
    for (const double bad : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
        CAPTURE(bad);
        UniformPlate size = good, rigidity = good, foundation = good;
        size.size_m[1] = bad;
        rigidity.rigidity_n_m = bad;
        foundation.foundation_n_per_m3 = bad;
        refused(size, {{0.5, 0.5}});
        refused(rigidity, {{0.5, 0.5}});
        if (bad != 0.0) refused(foundation, {{0.5, 0.5}});
        refused(good, {{0.5, bad}});
        if (bad != 0.0) refused(good, {{0.5, 0.5}, bad});
    }
    refused(good, {{1.0, 0.5}});
    refused(good, {{0.2, 0.5}, 0.3});                          // reaches over the edge
    refused(plate_of({10.0, 10.0}, 10.0), {{5.0, 5.0}, 0.7});  // 7 l
    CHECK_THROWS_WITH(UniformSolution(plate, {{0.5, 0.5}}), Catch::Contains("free edge"));
}

}  // namespace
}  // namespace palpate::plate
