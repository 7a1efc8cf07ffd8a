#include "host/plate/reference/request.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace palpate::reference {
namespace {

constexpr std::size_t NODES_MAX = 1025;  ///< along a side

void require(bool good, const std::string& what) {
    if (!good) throw BadRequest(what);
}

Plate parse(const nlohmann::json& request) {
    Plate plate;
    const auto size = request.at("size_m").get<std::array<double, 2>>();
    const auto nodes = request.at("nodes").get<std::array<std::size_t, 2>>();
    plate.size_x_m = size[0];
    plate.size_z_m = size[1];
    plate.nx = nodes[0];
    plate.nz = nodes[1];
    plate.poisson = request.value("poisson", plate.poisson);
    plate.depth_m = request.value("depth_m", plate.depth_m);
    plate.rigidity_n_m = request.at("rigidity_n_m").get<std::vector<double>>();
    plate.foundation_n_per_m3 = request.value("foundation_n_per_m3", std::vector<double>{});
    const auto contact =
        request.value("contact_node", std::array<std::size_t, 2>{plate.nx / 2, plate.nz / 2});
    plate.contact_ix = contact[0];
    plate.contact_iz = contact[1];
    return plate;
}

void check(const Plate& plate) {
    const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
    const auto not_negative = [](double x) { return x >= 0.0 && std::isfinite(x); };
    require(positive(plate.size_x_m) && positive(plate.size_z_m), "size_m: both must be positive");
    require(plate.nx >= 5 && plate.nz >= 5 && plate.nx <= NODES_MAX && plate.nz <= NODES_MAX,
            "nodes: each must lie between 5 and " + std::to_string(NODES_MAX));
    require(plate.poisson > -1.0 && plate.poisson < 0.5, "poisson: must lie between -1 and 0.5");
    require(positive(plate.depth_m), "depth_m: must be positive");
    const std::size_t n = plate.nx * plate.nz;
    require(plate.rigidity_n_m.size() == n, "rigidity_n_m: needs nodes[0] * nodes[1] values");
    require(std::all_of(plate.rigidity_n_m.begin(), plate.rigidity_n_m.end(), positive),
            "rigidity_n_m: every value must be positive");
    const std::vector<double>& foundation = plate.foundation_n_per_m3;
    require(foundation.empty() || foundation.size() == n,
            "foundation_n_per_m3: needs nodes[0] * nodes[1] values");
    require(std::all_of(foundation.begin(), foundation.end(), not_negative),
            "foundation_n_per_m3: no value may be negative");
    require(plate.contact_ix >= 1 && plate.contact_ix + 1 < plate.nx && plate.contact_iz >= 1 &&
                plate.contact_iz + 1 < plate.nz,
            "contact_node: must lie inside the clamped edge");
}

}  // namespace

Plate read_plate(std::istream& in) {
    try {
        const Plate plate = parse(nlohmann::json::parse(in));
        check(plate);
        return plate;
    } catch (const nlohmann::json::exception& error) {
        throw BadRequest(error.what());
    }
}

std::string answer_text(const Answer& answer) {
    return nlohmann::json{{"reaction_n", answer.reaction_n},
                          {"compliance_m_per_n", answer.compliance_m_per_n},
                          {"iterations", answer.iterations}}
        .dump();
}

}  // namespace palpate::reference
