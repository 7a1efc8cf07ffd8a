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

/// The library would cast without a word: -1 to the largest count, 5.7 to 5, and 1e30 to anything.
std::array<std::size_t, 2> counts(const nlohmann::json& value, const std::string& key) {
    const auto whole = [](const nlohmann::json& item) { return item.is_number_unsigned(); };
    require(value.is_array() && value.size() == 2 && std::all_of(value.begin(), value.end(), whole),
            key + ": needs two whole numbers, not negative");
    return {value[0].get<std::size_t>(), value[1].get<std::size_t>()};
}

Plate parse(const nlohmann::json& request) {
    Plate plate;
    const auto size = request.at("size_m").get<std::array<double, 2>>();
    const auto nodes = counts(request.at("nodes"), "nodes");
    plate.size_x_m = size[0];
    plate.size_z_m = size[1];
    plate.nx = nodes[0];
    plate.nz = nodes[1];
    plate.poisson = request.value("poisson", plate.poisson);
    plate.depth_m = request.value("depth_m", plate.depth_m);
    plate.rigidity_n_m = request.at("rigidity_n_m").get<std::vector<double>>();
    plate.foundation_n_per_m3 = request.value("foundation_n_per_m3", std::vector<double>{});
    const nlohmann::json middle = {plate.nx / 2, plate.nz / 2};
    const auto contact = counts(request.value("contact_node", middle), "contact_node");
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
    // Without a sum: one more than the largest index is 0.
    require(plate.contact_ix >= 1 && plate.contact_ix < plate.nx - 1 && plate.contact_iz >= 1 &&
                plate.contact_iz < plate.nz - 1,
            "contact_node: must lie inside the clamped edge");
}

}  // namespace

Plate read_plate(std::istream& in) {
    try {
        Plate plate = parse(nlohmann::json::parse(in));
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
