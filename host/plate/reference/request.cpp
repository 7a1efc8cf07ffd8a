#include "host/plate/reference/request.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

namespace palpate::reference {
namespace {

constexpr std::size_t NODES_MAX = 1025;  ///< along a side
constexpr std::size_t ELEMENTS_MAX = 256;
constexpr std::size_t DEPTHS_MAX = 256;

void require(bool good, const std::string& what) {
    if (!good) throw BadRequest(what);
}

bool positive(double x) {
    return x > 0.0 && std::isfinite(x);
}

bool not_negative(double x) {
    return x >= 0.0 && std::isfinite(x);
}

void refuse_others(const nlohmann::json& request, std::initializer_list<std::string_view> keys) {
    require(request.is_object(), "the problem: needs to be an object");
    for (const auto& item : request.items()) {
        require(std::find(keys.begin(), keys.end(), item.key()) != keys.end(), item.key() + ": no such key");
    }
}

/// The library would cast without a word: -1 to the largest count, 5.7 to 5, and 1e30 to anything.
std::array<std::size_t, 2> counts(const nlohmann::json& value, const std::string& key) {
    const auto whole = [](const nlohmann::json& item) { return item.is_number_unsigned(); };
    require(value.is_array() && value.size() == 2 && std::all_of(value.begin(), value.end(), whole),
            key + ": needs two whole numbers, not negative");
    return {value[0].get<std::size_t>(), value[1].get<std::size_t>()};
}

/// A list, or one number for all nodes.
std::vector<double> field(const nlohmann::json& value, std::size_t n) {
    return value.is_number() ? std::vector<double>(n, value.get<double>()) : value.get<std::vector<double>>();
}

double poisson_of(const nlohmann::json& request) {
    const double poisson = request.value("poisson", 0.2);
    require(poisson > -1.0 && poisson < 0.5, "poisson: must lie between -1 and 0.5");
    return poisson;
}

double positive_of(const nlohmann::json& request, const std::string& key) {
    const double x = request.at(key).get<double>();
    require(positive(x), key + ": must be positive");
    return x;
}

std::array<double, 2> pair_of(const nlohmann::json& pair, const std::string& key) {
    require(pair.is_array() && pair.size() == 2 && pair[0].is_number() && pair[1].is_number(),
            key + ": needs two numbers");
    return pair.get<std::array<double, 2>>();
}

void read_sides(const nlohmann::json& request, Plate& plate) {
    const auto size = pair_of(request.at("size_m"), "size_m");
    const auto nodes = counts(request.at("nodes"), "nodes");
    plate.size_x_m = size[0];
    plate.size_z_m = size[1];
    plate.nx = nodes[0];
    plate.nz = nodes[1];
    require(positive(plate.size_x_m) && positive(plate.size_z_m), "size_m: both must be positive");
    require(plate.nx >= 5 && plate.nz >= 5 && plate.nx <= NODES_MAX && plate.nz <= NODES_MAX,
            "nodes: each must lie between 5 and " + std::to_string(NODES_MAX));
}

void read_fields(const nlohmann::json& request, Plate& plate) {
    const std::size_t n = plate.nx * plate.nz;
    plate.rigidity_n_m = field(request.at("rigidity_n_m"), n);
    require(plate.rigidity_n_m.size() == n, "rigidity_n_m: needs one number, or nodes[0] * nodes[1]");
    require(std::all_of(plate.rigidity_n_m.begin(), plate.rigidity_n_m.end(), positive),
            "rigidity_n_m: every value must be positive");
    std::vector<double>& foundation = plate.foundation_n_per_m3;
    foundation = field(request.value("foundation_n_per_m3", nlohmann::json::array()), n);
    require(foundation.empty() || foundation.size() == n,
            "foundation_n_per_m3: needs one number, or nodes[0] * nodes[1]");
    require(std::all_of(foundation.begin(), foundation.end(), not_negative),
            "foundation_n_per_m3: no value may be negative");
}

/// All but the depth.
Plate plate_of(const nlohmann::json& request) {
    Plate plate;
    read_sides(request, plate);
    plate.poisson = poisson_of(request);
    read_fields(request, plate);
    const nlohmann::json middle = {plate.nx / 2, plate.nz / 2};
    const auto contact = counts(request.value("contact_node", middle), "contact_node");
    plate.contact_ix = contact[0];
    plate.contact_iz = contact[1];
    // Without a sum: one more than the largest index is 0.
    require(plate.contact_ix >= 1 && plate.contact_ix < plate.nx - 1 && plate.contact_iz >= 1 &&
                plate.contact_iz < plate.nz - 1,
            "contact_node: must lie inside the clamped edge");
    return plate;
}

Edge edge_of(const nlohmann::json& request) {
    const std::string edge = request.value("edge", "fixed");
    require(edge == "fixed" || edge == "free", "edge: must be \"fixed\" or \"free\"");
    return edge == "fixed" ? Edge::fixed : Edge::free;
}

std::array<double, 2> curvatures_of(const nlohmann::json& request) {
    const auto curvature =
        pair_of(request.value("curvature_per_m", nlohmann::json{0.0, 0.0}), "curvature_per_m");
    require(std::isfinite(curvature[0]) && std::isfinite(curvature[1]),
            "curvature_per_m: both must be finite");
    return curvature;
}

std::size_t elements_of(const nlohmann::json& request, std::size_t otherwise) {
    const nlohmann::json elements = request.value("elements", nlohmann::json(otherwise));
    require(elements.is_number_unsigned() && elements.get<std::size_t>() >= 4 &&
                elements.get<std::size_t>() <= ELEMENTS_MAX,
            "elements: must be a whole number between 4 and " + std::to_string(ELEMENTS_MAX));
    return elements.get<std::size_t>();
}

std::vector<double> depths_of(const nlohmann::json& request) {
    auto depths_m = request.at("depths_m").get<std::vector<double>>();
    require(!depths_m.empty() && depths_m.size() <= DEPTHS_MAX,
            "depths_m: needs 1 to " + std::to_string(DEPTHS_MAX) + " values");
    require(std::all_of(depths_m.begin(), depths_m.end(), positive) &&
                std::is_sorted(depths_m.begin(), depths_m.end()),
            "depths_m: every value must be positive, the smallest first");
    return depths_m;
}

template <class Read>
auto parsed(std::istream& in, const Read& read) {
    try {
        return read(nlohmann::json::parse(in));
    } catch (const nlohmann::json::exception& error) {
        throw BadRequest(error.what());
    }
}

}  // namespace

Plate read_plate(std::istream& in) {
    return parsed(in, [](const nlohmann::json& request) {
        refuse_others(request, {"size_m", "nodes", "rigidity_n_m", "foundation_n_per_m3", "poisson",
                                "depth_m", "contact_node"});
        Plate plate = plate_of(request);
        plate.depth_m = request.value("depth_m", plate.depth_m);
        require(positive(plate.depth_m), "depth_m: must be positive");
        return plate;
    });
}

Press<Shell> read_shell(std::istream& in) {
    return parsed(in, [](const nlohmann::json& request) {
        refuse_others(request, {"size_m", "nodes", "rigidity_n_m", "foundation_n_per_m3", "poisson",
                                "contact_node", "thickness_m", "curvature_per_m", "edge", "depths_m"});
        const auto curvature = curvatures_of(request);
        return Press<Shell>{.body = {.plate = plate_of(request),
                                     .thickness_m = positive_of(request, "thickness_m"),
                                     .curvature_x_per_m = curvature[0],
                                     .curvature_z_per_m = curvature[1],
                                     .edge = edge_of(request)},
                            .depths_m = depths_of(request)};
    });
}

Press<Square> read_square(std::istream& in) {
    return parsed(in, [](const nlohmann::json& request) {
        refuse_others(request, {"side_m", "thickness_m", "rigidity_n_m", "poisson", "curvature_per_m", "edge",
                                "elements", "depths_m"});
        const auto curvature = curvatures_of(request);
        return Press<Square>{.body = {.side_m = positive_of(request, "side_m"),
                                      .thickness_m = positive_of(request, "thickness_m"),
                                      .rigidity_n_m = positive_of(request, "rigidity_n_m"),
                                      .poisson = poisson_of(request),
                                      .curvature_x_per_m = curvature[0],
                                      .curvature_z_per_m = curvature[1],
                                      .edge = edge_of(request),
                                      .elements = elements_of(request, 12)},
                             .depths_m = depths_of(request)};
    });
}

Press<Cap> read_cap(std::istream& in) {
    return parsed(in, [](const nlohmann::json& request) {
        refuse_others(request, {"radius_m", "thickness_m", "rigidity_n_m", "poisson", "curvature_per_m",
                                "edge", "elements", "depths_m"});
        const double curvature = request.value("curvature_per_m", 0.0);
        require(std::isfinite(curvature), "curvature_per_m: must be finite");
        return Press<Cap>{.body = {.radius_m = positive_of(request, "radius_m"),
                                   .thickness_m = positive_of(request, "thickness_m"),
                                   .rigidity_n_m = positive_of(request, "rigidity_n_m"),
                                   .poisson = poisson_of(request),
                                   .curvature_per_m = curvature,
                                   .edge = edge_of(request),
                                   .elements = elements_of(request, 64)},
                          .depths_m = depths_of(request)};
    });
}

std::string answer_text(const Answer& answer) {
    return nlohmann::json{{"reaction_n", answer.reaction_n},
                          {"compliance_m_per_n", answer.compliance_m_per_n},
                          {"iterations", answer.iterations}}
        .dump();
}

std::string answer_text(const Pressed& pressed) {
    return nlohmann::json{
        {"depths_m", pressed.depths_m},     {"reaction_n", pressed.reaction_n},
        {"energy_j", pressed.energy_j},     {"force_ratio", pressed.force_ratio},
        {"iterations", pressed.iterations}, {"linear_stiffness_n_per_m", pressed.linear_stiffness_n_per_m}}
        .dump();
}

}  // namespace palpate::reference
